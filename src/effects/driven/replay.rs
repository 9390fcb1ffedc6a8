//! Replay of trials on a model, with the derivative of every tip position.

use super::driven_model::DrivenModel;
use crate::base::{PlantError, Point3, Rows, TendonCommand};
use crate::effects::VariationError;
use crate::effects::model::parameter::Variable;
use crate::effects::{EffectSpec, Model, Starts};
use crate::rod::TipWrench;

/// Relative step for finite differences of whole trials: balances truncation against solver
/// tolerance.
const TRIAL_STEP: f64 = 1e-4;

/// Commands of one trial.
#[derive(Clone, Copy, Debug)]
pub struct Trial<'a> {
    /// One row per command, one number per tendon: displacements in metres, or tensions in newtons.
    pub commands: &'a Rows,
    /// Duration of each command, s; ignored for `at_rest`.
    pub durations_s: &'a [f64],
    /// Whether the commands are tensions.
    pub tensions: bool,
    /// Every command is held until the robot is at rest.
    pub at_rest: bool,
    /// State at the start. A trial on its own continues none: `continue` is `home`.
    pub starts: Starts,
    /// Tip load during each command, in addition to the model's.
    pub tip_loads: Option<&'a [TipWrench]>,
}

/// Tracked positions of a replay and the derivatives of the tip.
#[derive(Clone, Debug, PartialEq)]
pub struct Replayed {
    /// Measured position before the first command, then at the end of each, metres.
    pub tips_m: Vec<Point3>,
    /// For each of them: the tracked points at that time, in the order of the model's
    /// `tracking.points`, metres.
    pub points_m: Vec<Vec<Point3>>,
    /// For each of them: derivative with respect to each variable, metres per unit of it; not a
    /// number where none leads across the last command.
    pub rates: Vec<Vec<Point3>>,
}

/// Why a trial cannot be replayed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReplayError {
    /// The model cannot follow the commands.
    #[error(transparent)]
    Plant(#[from] PlantError),
    /// A derivative does not exist.
    #[error(transparent)]
    Variation(#[from] VariationError),
    /// The number of durations or loads differs from the number of commands.
    #[error("{what}: found {found}, expected one per command, {expected}")]
    Count {
        /// What was counted.
        what: &'static str,
        /// Number given.
        found: usize,
        /// Number of commands.
        expected: usize,
    },
}

/// Replays `trial` from rest at home (tension commands: from rest without tension) or, where it
/// starts `anywhere`, from rest under its first command, on a checked model with `extra` effects.
/// Variables whose perturbation changes the discretisation are differentiated by finite differences
/// of the whole trial.
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
        let tips = |candidate: &Model| {
            trial.play(&mut DrivenModel::new(candidate, extra)).map(|played| played.tips_m)
        };
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
            if found == expected {
                Ok(())
            } else {
                Err(ReplayError::Count { what, found, expected })
            }
        };
        counted("tip loads", self.tip_loads.map_or(expected, <[TipWrench]>::len))?;
        counted("durations", if self.at_rest { expected } else { self.durations_s.len() })
    }

    fn play(&self, driven: &mut DrivenModel) -> Result<Replayed, ReplayError> {
        let mut replayed = Replayed { tips_m: Vec::new(), points_m: Vec::new(), rates: Vec::new() };
        match (self.starts, self.tensions) {
            (Starts::Anywhere, _) if !self.commands.is_empty() => self.begin_away(driven)?,
            (_, true) => driven.slack()?,
            (_, false) => driven.home()?,
        }
        replayed.add(driven);
        for (index, command) in self.commands.iter().enumerate() {
            self.load(driven, index);
            let pulls: Vec<TendonCommand> =
                command.iter().map(|&pull| TendonCommand::Pull(pull)).collect();
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

    /// Settles under the first command.
    fn begin_away(&self, driven: &mut DrivenModel) -> Result<(), PlantError> {
        driven.restart_away();
        self.load(driven, 0);
        let first = self.commands.row(0);
        if self.tensions {
            driven.settle_under(first)?;
        } else {
            driven
                .settle(&first.iter().map(|&pull| TendonCommand::Pull(pull)).collect::<Vec<_>>())?;
        }
        driven.restart_count();
        Ok(())
    }

    /// Puts the load of a command on the tip.
    fn load(&self, driven: &mut DrivenModel, index: usize) {
        if let Some(loads) = self.tip_loads {
            driven.set_extra_tip_load(&|_| loads[index]);
        }
    }
}

impl Replayed {
    fn add(&mut self, driven: &DrivenModel) {
        let seen = driven.observation(&[], 0.0);
        self.tips_m.push(seen.tip_m);
        self.points_m.push(seen.points.iter().map(|point| point.position_m).collect());
        self.rates.push(driven.tip_rates().iter().map(|rate| rate.position_m.into()).collect());
    }
}
