//! Finds an axis that counts its steps and does not move its tendon, by the tips of a whole trial.
//!
//! The model plays the trial once more for each axis, as if that axis had stood at home. If one of
//! these tips fits the measured ones much better than those of four moving axes, that axis stood. A
//! tendon only pulls: an axis that lets out and stands hardly changes the tip, and is not found.

use std::fmt;

use super::trial_log::TrialLog;
use crate::base::{Point3, TendonCommand, distance_m};
use crate::effects::DrivenModel;
use crate::hardware::axes::AXES;
use crate::hardware::grbl::AXIS_NAMES;

/// Tips nearer than this to those of four moving axes, metres rms, raise no doubt: what lead screws
/// that take most of a tick make of a step.
const MIN_UNEXPLAINED_M: f64 = 0.004;
/// A blocked axis leaves at most this share of the distance unexplained.
const MAX_REMAINING_SHARE: f64 = 0.5;
/// An axis is judged if its commands span more than this, metres: more than backlash.
const MIN_SPAN_M: f64 = 0.003;
/// Axes whose distances differ by less than this factor are not told apart: opposite tendons that
/// move together.
const MIN_DISTINCT_RATIO: f64 = 1.25;
/// A robot may bend less or more than its model, by these factors.
const GAINS: [f64; 2] = [0.4, 2.5];
/// Most commands that are played again; of a longer trial every second, third, … one.
const MAX_PLAYED: usize = 200;

/// Axes of which one has not moved its tendon.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BlockedAxis {
    /// The best candidate first.
    axes: Vec<usize>,
    /// Distance of the tips from the model's if the first one stood, and if all moved, metres rms.
    if_blocked_m: f64,
    if_moving_m: f64,
}

impl fmt::Display for BlockedAxis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<String> = self
            .axes
            .iter()
            .map(|&axis| format!("{} (tendon {})", AXIS_NAMES[axis], axis + 1))
            .collect();
        write!(
            f,
            "axis {} did not move its tendon in this trial: the measured tips differ from the \
             predicted ones by {:.1} mm rms for an axis that stands and by {:.1} mm rms for one \
             that moves; its motor is blocked, its coupling slips, or its tendon has come off",
            names.join(" or "),
            self.if_blocked_m * 1e3,
            self.if_moving_m * 1e3
        )
    }
}

/// The axis that stood during `trial`, of commands in steps of `step_s`; none if four moving axes
/// explain the tips, or no standing one explains them much better.
pub(super) fn find_blocked(
    model: &DrivenModel,
    trial: &TrialLog,
    step_s: f64,
) -> Option<BlockedAxis> {
    let predicted_m: Vec<Point3> = trial.steps.iter().map(|step| step.predicted_m).collect();
    let if_moving_m = distance_rms_m(trial, 1, &trial.home_m, &predicted_m)?;
    if if_moving_m <= MIN_UNEXPLAINED_M {
        return None;
    }
    let mut candidates: Vec<(usize, f64)> = (0..AXES)
        .filter(|&axis| trial.span_m(axis) > MIN_SPAN_M)
        .filter_map(|axis| Some((axis, if_blocked_m(model, trial, step_s, axis)?)))
        .collect();
    candidates.sort_by(|a, b| a.1.total_cmp(&b.1));
    let &(_, if_blocked_m) = candidates.first()?;
    if if_blocked_m > MAX_REMAINING_SHARE * if_moving_m {
        return None;
    }
    let alike = |&&(_, distance_m): &&(usize, f64)| distance_m < MIN_DISTINCT_RATIO * if_blocked_m;
    let axes = candidates.iter().take_while(alike).map(|&(axis, _)| axis).collect();
    Some(BlockedAxis { axes, if_blocked_m, if_moving_m })
}

/// Distance of the tips from those of a model whose `axis` stands at home, metres rms; none if it
/// finds no equilibrium at home.
fn if_blocked_m(model: &DrivenModel, trial: &TrialLog, step_s: f64, axis: usize) -> Option<f64> {
    let mut model = model.clone();
    model.home().ok()?;
    let home_m = model.observation(&[TendonCommand::Pull(0.0); AXES], 0.0).tip_m;
    let stride = trial.steps.len().div_ceil(MAX_PLAYED);
    let (mut tip_m, mut tips_m) = (home_m, Vec::new());
    for step in trial.steps.iter().step_by(stride) {
        let mut pulls_m = step.pulls_m;
        pulls_m[axis] = 0.0;
        let commands = pulls_m.map(TendonCommand::Pull);
        // A rod without an equilibrium keeps its shape, as if stuck.
        if model.advance(&commands, step_s * stride as f64).is_ok() {
            tip_m = model.observation(&commands, 0.0).tip_m;
        }
        tips_m.push(tip_m);
    }
    distance_rms_m(trial, stride, &home_m, &tips_m)
}

/// Distance of the measured from the predicted tips of every `stride`-th step, both relative to
/// home, metres rms, for the gain that fits best; none without a measured tip.
fn distance_rms_m(
    trial: &TrialLog,
    stride: usize,
    home_m: &Point3,
    predicted_m: &[Point3],
) -> Option<f64> {
    let from = |tip_m: &Point3, home_m: &Point3| -> Point3 {
        std::array::from_fn(|axis| tip_m[axis] - home_m[axis])
    };
    let pairs: Vec<(Point3, Point3)> = trial
        .steps
        .iter()
        .step_by(stride)
        .zip(predicted_m)
        .filter_map(|(step, predicted_m)| {
            Some((from(&step.measured_m?, &trial.measured_home_m?), from(predicted_m, home_m)))
        })
        .collect();
    let dot = |a: &Point3, b: &Point3| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let common: f64 = pairs.iter().map(|(measured_m, model_m)| dot(measured_m, model_m)).sum();
    let power: f64 = pairs.iter().map(|(_, model_m)| dot(model_m, model_m)).sum();
    let gain = if power > 0.0 { (common / power).clamp(GAINS[0], GAINS[1]) } else { 1.0 };
    let squares = pairs.iter().map(|(measured_m, model_m)| {
        distance_m(measured_m, &model_m.map(|part| gain * part)).powi(2)
    });
    (!pairs.is_empty()).then(|| (squares.sum::<f64>() / pairs.len() as f64).sqrt())
}
