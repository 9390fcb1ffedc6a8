//! The commands of a recording, and what a model does under them.

use serde::{Deserialize, Serialize};

use super::error::BenchmarkError;
use crate::base::{Point3, Rows, Seed};
use crate::effects::{EffectSpec, Model, Trial, replay};
use crate::plants::{Simulated, SimulatedOptions};
use crate::tasks::{ExploreOptions, explore};

/// What the drives are told, trial by trial, at a constant rate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Commands {
    /// Time from one command to the next, seconds.
    pub step_s: f64,
    /// Displacements of each trial, metres: a row a command, a column a tendon.
    pub trials: Vec<Rows>,
}

/// Commands as the paper collects data: a random exploration of the model, trials from rest at home.
///
/// # Errors
/// [`BenchmarkError::Commands`] when the model cannot be explored so.
pub fn explore_commands(
    model: &Model,
    options: &ExploreOptions,
    step_s: f64,
    seed: Seed,
) -> Result<Commands, BenchmarkError> {
    let mut plant = Simulated::new(model, &[], SimulatedOptions { step_s, ..SimulatedOptions::default() });
    let samples = explore(&mut plant, options, seed)?;
    let trial = |range: std::ops::Range<usize>| samples.pulls_m.select(&range.collect::<Vec<usize>>());
    Ok(Commands { step_s, trials: samples.trajectories().into_iter().map(trial).collect() })
}

impl Commands {
    /// Number of samples: one before each command.
    pub fn len(&self) -> usize {
        self.trials.iter().map(Rows::len).sum()
    }

    /// True without any.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Where a model with `extra` effects has the tip before each command, metres; none where it cannot follow.
    pub fn tips_m(&self, model: &Model, extra: &[EffectSpec]) -> Option<Vec<Point3>> {
        let mut tips = Vec::with_capacity(self.len());
        for commands in &self.trials {
            // Nothing is seen of the last command.
            let count = commands.len() - 1;
            let commands = commands.select(&(0..count).collect::<Vec<usize>>());
            let durations_s = vec![self.step_s; count];
            let trial = Trial {
                commands: &commands,
                durations_s: &durations_s,
                tensions: false,
                at_rest: false,
                tip_loads: None,
            };
            tips.extend(replay(model, extra, &trial, &[]).ok()?.tips_m);
        }
        tips.iter().flatten().all(|x| x.is_finite()).then_some(tips)
    }
}

/// Root mean square distance of two ways of the tip, metres.
pub(crate) fn apart_m(here: &[Point3], there: &[Point3]) -> f64 {
    let square = |(a, b): (&Point3, &Point3)| (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>();
    (here.iter().zip(there).map(square).sum::<f64>() / here.len().max(1) as f64).sqrt()
}
