//! Trials played again on a model, with the derivative of every tip.

use super::driven_model::{DrivenModel, VariationError};
use super::model_parameter::Variable;
use super::{EffectSpec, Model};
use crate::base::{PlantError, Point3, Rows, TendonCommand};
use crate::rod::TipWrench;

/// Change of a number, over its scale, for differences of whole trials: rounding and what solves leave are then about
/// as large as the curvature of the dependence.
const TRIAL_STEP: f64 = 1e-4;

/// What the tendons are told in one trial.
#[derive(Clone, Copy, Debug)]
pub struct Trial<'a> {
    /// One row a command, one number a tendon: displacements in metres, or tensions in newtons.
    pub commands: &'a Rows,
    /// How long each command is held, s; of no account at rest.
    pub durations_s: &'a [f64],
    /// Whether the commands are tensions.
    pub tensions: bool,
    /// Every command is held until the robot is at rest.
    pub at_rest: bool,
    /// Load on the tip during each command, besides the model's.
    pub tip_loads: Option<&'a [TipWrench]>,
}

/// Where the tip was at the end of each command, and how that depends on numbers of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Replayed {
    /// Measured position before the first command, then at the end of each, metres.
    pub tips_m: Vec<Point3>,
    /// For each of them: derivative with respect to each variable, metres per unit of it.
    pub rates: Vec<Vec<Point3>>,
}

/// A trial cannot be played again.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReplayError {
    /// The model cannot follow the commands.
    #[error(transparent)]
    Plant(#[from] PlantError),
    /// There is no such derivative.
    #[error(transparent)]
    Variation(#[from] VariationError),
    /// Another number of durations or loads than of commands.
    #[error("{what}: found {found}, expected one a command, {expected}")]
    Count {
        /// Of what.
        what: &'static str,
        /// Number given.
        found: usize,
        /// Number of commands.
        expected: usize,
    },
}

/// Plays `trial` from rest at home (under tensions: from rest without any) on a checked model with `extra` effects.
/// Variables whose smallest change makes another discretisation are differentiated by playing the trial once more on
/// each side.
///
/// # Errors
/// [`ReplayError`].
pub fn replay(
    model: &Model,
    extra: &[EffectSpec],
    trial: &Trial,
    variables: &[Variable],
) -> Result<Replayed, ReplayError> {
    trial.check()?;
    let (mut driven, far) = DrivenModel::varied_where_possible(model, extra, variables)?;
    let mut replayed = trial.play(&mut driven)?;
    for index in far {
        let Variable::Parameter(parameter) = &variables[index] else {
            return Err(VariationError::NotPerturbable(index).into());
        };
        let tips = |candidate: &Model| trial.play(&mut DrivenModel::new(candidate, extra)).map(|played| played.tips_m);
        let rates = parameter.differences(model, TRIAL_STEP, &tips)?;
        for (row, rate) in replayed.rates.iter_mut().zip(rates) {
            row.insert(index, rate);
        }
    }
    Ok(replayed)
}

impl Trial<'_> {
    fn check(&self) -> Result<(), ReplayError> {
        let expected = self.commands.len();
        let counted = |what, found: usize| {
            if found == expected { Ok(()) } else { Err(ReplayError::Count { what, found, expected }) }
        };
        counted("tip loads", self.tip_loads.map_or(expected, <[TipWrench]>::len))?;
        counted("durations", if self.at_rest { expected } else { self.durations_s.len() })
    }

    fn play(&self, driven: &mut DrivenModel) -> Result<Replayed, ReplayError> {
        let mut replayed = Replayed { tips_m: Vec::new(), rates: Vec::new() };
        if self.tensions {
            driven.slack()?
        } else {
            driven.home()?
        }
        replayed.add(driven);
        for (index, command) in self.commands.iter().enumerate() {
            if let Some(loads) = self.tip_loads {
                driven.set_extra_tip_load(&|_| loads[index]);
            }
            let pulls: Vec<TendonCommand> = command.iter().map(|&pull| TendonCommand::Pull(pull)).collect();
            match (self.tensions, self.at_rest) {
                (false, false) => driven.advance(&pulls, self.durations_s[index])?,
                (false, true) => driven.settle(&pulls)?,
                (true, false) => driven.advance_under(command, self.durations_s[index])?,
                (true, true) => driven.settle_under(command)?,
            }
            replayed.add(driven);
        }
        Ok(replayed)
    }
}

impl Replayed {
    fn add(&mut self, driven: &DrivenModel) {
        self.tips_m.push(driven.observation(&[], 0.0).tip_m);
        self.rates.push(driven.tip_rates().iter().map(|rate| rate.position_m.into()).collect());
    }
}
