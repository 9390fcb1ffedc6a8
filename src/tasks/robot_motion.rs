//! What a robot does while it is recorded: random walks, or drives across the workspace, from home to a drawn bend and from
//! there to the next. Twenty steps of a drive reach the edge of the workspace, which those of a walk do not.

use rand::RngExt;
use serde::{Deserialize, Serialize};

use super::actuation::{Bend, BendMap};
use super::explore::{ExploreOptions, explore};
use super::retry_lost_frames::RetryLostFrames;
use super::{TaskError, Transitions};
use crate::base::{Generator, Plant, Seed};

/// What the robot does while it is recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RecordedMotion {
    /// Random walks, as those of `explore`.
    Walk,
    /// Drives in straight lines from one drawn bend to the next, across the whole workspace.
    Drives,
}

impl RecordedMotion {
    /// Records a robot that moves so, within the limits of `options`.
    ///
    /// # Errors
    /// [`TaskError`] for a setting out of range, a plant whose tendons are all on one side, or one that fails.
    pub fn record(self, plant: &mut dyn Plant, options: &ExploreOptions, seed: Seed) -> Result<Transitions, TaskError> {
        match self {
            RecordedMotion::Walk => explore(plant, options, seed),
            RecordedMotion::Drives => drives(plant, options, seed),
        }
    }
}

/// Records drives between drawn bends, in straight lines of the actuation plane: `options.trajectories` trajectories, each
/// from rest at home, `options.points` transitions in all. Bends are uniform within `max_pull_m`.
///
/// # Errors
/// [`TaskError`] for a setting out of range, a plant whose tendons are all on one side, or one that fails.
pub fn drives(plant: &mut dyn Plant, options: &ExploreOptions, seed: Seed) -> Result<Transitions, TaskError> {
    options.check()?;
    let map = BendMap::of(plant)?;
    let mut plant = RetryLostFrames(plant);
    let mut trajectories = Vec::with_capacity(options.trajectories);
    for index in 0..options.trajectories {
        let seed = seed.child("drives").index(index as u64);
        let mut tip_m = plant.reset(seed.child("plant"))?.tip_m;
        let mut samples = Transitions::begin(plant.tendons());
        for bend_m in bends_m(map.straight(), options, options.share(index), &mut seed.child("bends").rng()) {
            let after = plant.drive(&map.commands(&bend_m))?;
            samples.push(&tip_m, &after);
            tip_m = after.tip_m;
        }
        trajectories.push(samples);
    }
    Ok(Transitions::concat(&trajectories))
}

/// The bend at the end of each of `count` steps, metres.
fn bends_m(home_m: Bend, options: &ExploreOptions, count: usize, random: &mut Generator) -> Vec<Bend> {
    let most_m = options.max_pull_m;
    let (mut bend_m, mut goal_m) = (home_m.clone(), home_m);
    let mut bends_m = Vec::with_capacity(count);
    for _ in 0..count {
        if bend_m == goal_m {
            goal_m = bend_m.iter().map(|_| random.random_range(-most_m..=most_m)).collect();
        }
        let farthest_m = bend_m.iter().zip(&goal_m).map(|(now, goal)| (goal - now).abs()).fold(0.0, f64::max);
        bend_m = if farthest_m <= options.max_step_m {
            goal_m.clone()
        } else {
            let share = options.max_step_m / farthest_m;
            bend_m.iter().zip(&goal_m).map(|(now, goal)| now + share * (goal - now)).collect()
        };
        bends_m.push(bend_m.clone());
    }
    bends_m
}
