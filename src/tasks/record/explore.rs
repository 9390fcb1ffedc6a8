//! Data for learning (section IV-A): "continuous random exploration of the actuators with a maximum
//! travel distance of 0.003 m each step", and the same commands on another robot (section V-A).

use rand::RngExt;
use serde::{Deserialize, Serialize};

use super::actuation::BendMap;
use super::retry_lost_frames::RetryLostFrames;
use crate::base::{BadOption, Plant, Seed, report_share};
use crate::tasks::{TaskError, Transitions};

/// Most points; a table of that size fits in memory.
const MAX_POINTS: usize = 10_000_000;

/// Settings of the exploration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ExploreOptions {
    /// Number of transitions in all trajectories.
    pub points: usize,
    /// Independent trajectories, each from rest at home; 1 is one continuous exploration.
    pub trajectories: usize,
    /// Largest change of an actuated tendon in a step.
    pub max_step_m: f64,
    /// Largest pull; a step beyond it is reversed.
    pub max_pull_m: f64,
}

impl Default for ExploreOptions {
    fn default() -> Self {
        ExploreOptions { points: 10_000, trajectories: 1, max_step_m: 0.003, max_pull_m: 0.03 }
    }
}

impl ExploreOptions {
    /// Checks every range.
    ///
    /// # Errors
    /// [`BadOption`] names the first field out of range.
    pub fn check(&self) -> Result<(), BadOption> {
        if self.points == 0 || self.points > MAX_POINTS {
            let found = self.points.to_string();
            return Err(BadOption { key: "points", found, expected: "1 to 10000000" });
        }
        BadOption::unless_counted("trajectories", self.trajectories)?;
        BadOption::unless_positive("max_step_m", self.max_step_m)?;
        BadOption::unless_positive("max_pull_m", self.max_pull_m)?;
        if self.max_step_m > self.max_pull_m {
            let found = self.max_step_m.to_string();
            return Err(BadOption { key: "max_step_m", found, expected: "at most `max_pull_m`" });
        }
        if self.trajectories > self.points {
            let found = self.trajectories.to_string();
            return Err(BadOption { key: "trajectories", found, expected: "at most `points`" });
        }
        Ok(())
    }

    /// Index of the first transition of each trajectory that begins within the first `count`
    /// transitions.
    pub fn starts(&self, count: usize) -> Vec<usize> {
        let begin = |next: &mut usize, index: usize| {
            let start = *next;
            *next += self.share(index);
            Some(start)
        };
        (0..self.trajectories).scan(0, begin).take_while(|start| *start < count).collect()
    }

    /// Number of transitions of trajectory `index`: equal shares, the first trajectories take the
    /// remainder.
    fn share(&self, index: usize) -> usize {
        self.points / self.trajectories + usize::from(index < self.points % self.trajectories)
    }
}

/// Trajectory `index` of an exploration. It depends on the seed and its index alone, so
/// trajectories can be recorded in parallel on separate plants and joined by
/// [`Transitions::concat`].
///
/// # Errors
/// [`TaskError`] for a setting out of range, a plant whose tendons are all on one side, or one that
/// fails.
pub fn explore_trajectory(
    plant: &mut dyn Plant,
    options: &ExploreOptions,
    seed: Seed,
    index: usize,
) -> Result<Transitions, TaskError> {
    options.check()?;
    let map = BendMap::of(plant)?;
    let mut plant = RetryLostFrames(plant);
    // A seed for each trajectory, so that they may be recorded in any order.
    let seed = seed.child("explore").index(index as u64);
    let mut random = seed.child("walk").rng();
    let mut tip_m = plant.reset(seed.child("plant"))?.tip_m;
    let mut bend_m = map.straight();
    let mut samples = Transitions::begin(plant.tendons());
    let rows = options.share(index);
    for row in 0..rows {
        report_share(row, rows);
        for value_m in &mut bend_m {
            let change_m = random.random_range(-options.max_step_m..=options.max_step_m);
            let next_m = *value_m + change_m;
            // Reflection at the limit keeps the step; clamping would gather points there.
            *value_m = if next_m.abs() > options.max_pull_m { *value_m - change_m } else { next_m };
        }
        let after = plant.drive(&map.commands(&bend_m))?;
        samples.push(&tip_m, &after);
        tip_m = after.tip_m;
    }
    plant.verify()?;
    Ok(samples)
}

/// A whole exploration, one trajectory after the other on the same plant.
///
/// # Errors
/// As [`explore_trajectory`].
pub fn explore(
    plant: &mut dyn Plant,
    options: &ExploreOptions,
    seed: Seed,
) -> Result<Transitions, TaskError> {
    options.check()?;
    let parts: Result<Vec<Transitions>, TaskError> = (0..options.trajectories)
        .map(|index| explore_trajectory(plant, options, seed, index))
        .collect();
    Ok(Transitions::concat(&parts?))
}

/// Replays the commands of trajectory `index` of `samples` on a plant, from rest.
///
/// # Errors
/// [`TaskError::TooFew`] when there is no such trajectory, [`TaskError::Plant`] when the plant
/// fails.
pub fn replay_trajectory(
    plant: &mut dyn Plant,
    samples: &Transitions,
    seed: Seed,
    index: usize,
) -> Result<Transitions, TaskError> {
    let ranges = samples.trajectories();
    let range = ranges.get(index).cloned().ok_or(TaskError::TooFew {
        what: "trajectories to replay",
        required: index + 1,
        available: ranges.len(),
    })?;
    let mut plant = RetryLostFrames(plant);
    let mut tip_m = plant.reset(seed.child("replay").index(index as u64))?.tip_m;
    let mut replayed = Transitions::begin(plant.tendons());
    for row in range.clone() {
        report_share(row - range.start, range.len());
        let after = plant.step(samples.pulls_m.row(row))?;
        replayed.push(&tip_m, &after);
        tip_m = after.tip_m;
    }
    plant.verify()?;
    Ok(replayed)
}

/// Replays all trajectories of `samples` on a plant: the response of the "real" robot to the same
/// inputs.
///
/// # Errors
/// As [`replay_trajectory`].
pub fn replay(
    plant: &mut dyn Plant,
    samples: &Transitions,
    seed: Seed,
) -> Result<Transitions, TaskError> {
    let parts: Result<Vec<Transitions>, TaskError> = (0..samples.starts.len())
        .map(|index| replay_trajectory(plant, samples, seed, index))
        .collect();
    Ok(Transitions::concat(&parts?))
}
