//! Commands of a recording and their simulation.

use serde::{Deserialize, Serialize};

use super::error::BenchmarkError;
use crate::base::{Point3, Rows, Seed};
use crate::effects::replay;
use crate::effects::{EffectSpec, Model, Trial};
use crate::plants::{Simulated, SimulatedOptions};
use crate::tasks::ExploreOptions;
use crate::tasks::explore;

/// Commands of the drives, trial by trial, at a constant rate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Commands {
    /// Time between commands, seconds.
    pub step_s: f64,
    /// Displacements of each trial, metres: one row a command, one column a tendon.
    pub trials: Vec<Rows>,
}

/// Commands as in the paper's data collection: random exploration of the model, each trial from
/// rest at home.
///
/// # Errors
/// [`BenchmarkError::Commands`] if the exploration fails.
pub fn explore_commands(
    model: &Model,
    options: &ExploreOptions,
    step_s: f64,
    seed: Seed,
) -> Result<Commands, BenchmarkError> {
    let mut plant =
        Simulated::new(model, &[], SimulatedOptions { step_s, ..SimulatedOptions::default() });
    let samples = explore(&mut plant, options, seed)?;
    let trial =
        |range: std::ops::Range<usize>| samples.pulls_m.select(&range.collect::<Vec<usize>>());
    Ok(Commands { step_s, trials: samples.trajectories().into_iter().map(trial).collect() })
}

impl Commands {
    /// Number of samples: one before each command.
    pub fn len(&self) -> usize {
        self.trials.iter().map(Rows::len).sum()
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Simulated tip before each command with `extra` effects, metres; none if the simulation
    /// fails.
    pub fn tips_m(&self, model: &Model, extra: &[EffectSpec]) -> Option<Vec<Point3>> {
        let mut tips = Vec::with_capacity(self.len());
        for commands in &self.trials {
            // The result of the last command is not recorded.
            let count = commands.len() - 1;
            let commands = commands.select(&(0..count).collect::<Vec<usize>>());
            let durations_s = vec![self.step_s; count];
            let trial = Trial {
                commands: &commands,
                durations_s: &durations_s,
                tensions: false,
                at_rest: false,
                starts: model.tracking.starts,
                tip_loads: None,
            };
            tips.extend(replay(model, extra, &trial, &[]).ok()?.tips_m);
        }
        tips.iter().flatten().all(|x| x.is_finite()).then_some(tips)
    }
}

/// Rms distance between two tip paths, metres.
pub(crate) fn rms_distance_m(first: &[Point3], second: &[Point3]) -> f64 {
    let square =
        |(a, b): (&Point3, &Point3)| (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>();
    (first.iter().zip(second).map(square).sum::<f64>() / first.len().max(1) as f64).sqrt()
}
