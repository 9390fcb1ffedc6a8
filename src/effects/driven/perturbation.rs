//! A model with one variable slightly changed: what follows the model to give a derivative.

use std::ops::Range;

use crate::effects::model::parameter::{Variable, VariationError};
use crate::effects::model::tracking::TrackedPlaces;
use crate::effects::{Effect, EffectSpec, Model};
use crate::rod::{PerturbedRods, RodParams};

/// Relative perturbation for derivatives: balances truncation against rounding.
const RELATIVE_STEP: f64 = 1e-7;

/// Perturbation of one follower.
#[derive(Clone, Debug)]
pub(crate) struct Perturbation {
    /// Change of the variable, in its unit.
    pub(crate) step: f64,
    /// What changes of the commands.
    shift: CommandShift,
}

/// What a perturbation changes of the commands.
#[derive(Clone, Debug)]
enum CommandShift {
    /// Nothing: it changes the robot or what is measured.
    Nothing,
    /// The commands of this tendon with these indices.
    Commands(usize, Range<usize>),
    /// The displacement of this tendon per displacement of this drive, both from 0.
    Gain { tendon: usize, drive: usize },
}

/// A perturbed model.
pub(crate) struct PerturbedModel {
    pub(crate) perturbation: Perturbation,
    pub(crate) drive_time_s: f64,
    pub(crate) params: RodParams,
    pub(crate) effects: Vec<Box<dyn Effect>>,
    pub(crate) places: TrackedPlaces,
}

impl Perturbation {
    /// The tendon and shift of the command with index `number`, if this perturbation changes it;
    /// `drives` are the displacements of the drives in this command.
    pub(crate) fn shift(&self, number: Option<usize>, drives: &[f64]) -> Option<(usize, f64)> {
        match &self.shift {
            CommandShift::Nothing => None,
            CommandShift::Commands(tendon, commands) => {
                commands.contains(&number?).then_some((*tendon, self.step))
            }
            CommandShift::Gain { tendon, drive } => {
                drives.get(*drive).map(|moved| (*tendon, self.step * moved))
            }
        }
    }
}

/// The gain in which two models differ, if they do.
fn changed_gain(model: &Model, candidate: &Model) -> CommandShift {
    let pairs = model.drives.values().zip(candidate.drives.values()).enumerate();
    let gains = pairs.flat_map(|(drive, (drive_before, drive_after))| {
        let each = drive_before.gains.iter().zip(&drive_after.gains).zip(&drive_before.tendons);
        each.map(move |((before, after), tendon)| {
            (before != after, CommandShift::Gain { tendon: tendon - 1, drive })
        })
    });
    gains
        .into_iter()
        .find(|(differs, _)| *differs)
        .map_or(CommandShift::Nothing, |(_, shift)| shift)
}

/// The model with one variable perturbed.
pub(crate) fn perturb(
    model: &Model,
    extra: &[EffectSpec],
    variable: &Variable,
    index: usize,
) -> Result<PerturbedModel, VariationError> {
    let params = model.rod(extra);
    let of_model = |step: f64, shift: CommandShift, params: RodParams| PerturbedModel {
        perturbation: Perturbation { step, shift },
        drive_time_s: model.robot.drive_time_s,
        params,
        effects: model.effects(extra),
        places: model.tracking.places(),
    };
    let axis = |axis: usize| if axis < 3 { Ok(axis) } else { Err(VariationError::Missing(index)) };
    let mut changed = params.clone();
    match variable {
        Variable::Parameter(parameter) => {
            let (value, scale) = (parameter.value(model)?, parameter.scale(model)?);
            // Backwards where a step forwards leaves the range or changes the grid.
            for step in [RELATIVE_STEP * scale, -RELATIVE_STEP * scale] {
                // The perturbation after rounding of the sum.
                let (there, step) = (value + step, (value + step) - value);
                let candidate = parameter.with_value(model, there)?;
                let changed = candidate.rod(extra);
                if candidate.check().is_ok() && PerturbedRods::possible(&params, &changed) {
                    let effects = candidate.effects(extra);
                    let drive_time_s = candidate.robot.drive_time_s;
                    let perturbation =
                        Perturbation { step, shift: changed_gain(model, &candidate) };
                    let places = candidate.tracking.places();
                    return Ok(PerturbedModel {
                        perturbation,
                        drive_time_s,
                        params: changed,
                        effects,
                        places,
                    });
                }
            }
            Err(VariationError::NotPerturbable(index))
        }
        Variable::Command { tendon, commands } => {
            if *tendon >= params.tendons.len() {
                return Err(VariationError::Missing(index));
            }
            Ok(of_model(
                RELATIVE_STEP * COMMAND_SCALE,
                CommandShift::Commands(*tendon, commands.clone()),
                params,
            ))
        }
        Variable::Force(along) => {
            changed.tip_load.force_n[axis(*along)?] += RELATIVE_STEP * FORCE_SCALE_N;
            Ok(of_model(RELATIVE_STEP * FORCE_SCALE_N, CommandShift::Nothing, changed))
        }
        Variable::Moment(about) => {
            changed.tip_load.moment_nm[axis(*about)?] += RELATIVE_STEP * MOMENT_SCALE_NM;
            Ok(of_model(RELATIVE_STEP * MOMENT_SCALE_NM, CommandShift::Nothing, changed))
        }
    }
}

/// Scales: 10 mm or N of a command, of a force, and of a moment at the tip.
const COMMAND_SCALE: f64 = 0.01;
const FORCE_SCALE_N: f64 = 0.1;
const MOMENT_SCALE_NM: f64 = 0.01;
