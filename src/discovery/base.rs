//! What markers on the base say: whether the base is tilted or the tracking frame turned, which look alike at the tip.

use nalgebra::{Quaternion, UnitQuaternion};

use super::hypothesis::{Hypothesis, Member};
use crate::data::Recording;
use crate::effects::{EffectSpec, Model};
use crate::math::summary::{mean, standard_deviation};

/// The base's tilt as tracked.
#[derive(Clone, Copy, Debug)]
pub(super) struct BaseSeen {
    /// About x and y, radians.
    tilt_rad: [f64; 2],
    /// Standard deviation of each.
    deviation_rad: f64,
}

/// Markers on a base stand no straighter than this, radians.
const MOUNTED_RAD: f64 = 2e-3;

impl BaseSeen {
    /// The mean of what was tracked; none without base markers.
    pub(super) fn of(measured: &Recording) -> Option<BaseSeen> {
        let turns: Vec<[f64; 2]> = measured
            .base
            .as_ref()?
            .iter()
            .filter(|pose| pose.quaternion.iter().all(|q| q.is_finite()))
            .map(|pose| {
                let [w, x, y, z] = pose.quaternion;
                let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).scaled_axis();
                [turn.x, turn.y]
            })
            .collect();
        let about = |axis: usize| turns.iter().map(|turn| turn[axis]).collect::<Vec<f64>>();
        let scatter = standard_deviation(&about(0)).max(standard_deviation(&about(1)));
        let deviation_rad = MOUNTED_RAD.hypot(scatter / (turns.len() as f64).sqrt());
        (turns.len() > 1).then(|| BaseSeen { tilt_rad: [mean(&about(0)), mean(&about(1))], deviation_rad })
    }

    /// What it adds to the deviance of `model` with `members`.
    pub(super) fn deviance(&self, model: &Model, hypotheses: &[Hypothesis], members: &[Member]) -> f64 {
        let own = model.effects.iter().cloned();
        let added = members.iter().filter_map(|member| hypotheses[member.hypothesis].effect(&member.values));
        let mut expected = [0.0; 2];
        for effect in own.chain(added) {
            if let EffectSpec::BaseTilt(tilt) = effect {
                expected[0] += tilt.tilt_x_rad;
                expected[1] += tilt.tilt_y_rad;
            }
        }
        (0..2).map(|axis| ((self.tilt_rad[axis] - expected[axis]) / self.deviation_rad).powi(2)).sum()
    }
}
