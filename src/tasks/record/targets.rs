//! Targets of goal reaching (section V-B): "randomly picking 50 target points from another 960
//! unique points spaced equally in the real workspace".

use rand::seq::SliceRandom;
use serde::{Deserialize, Serialize};

use super::actuation::{BendMap, GridOptions, drive_to};
use super::retry_lost_frames::RetryLostFrames;
use crate::base::{BadOption, Plant, Point3, Seed};
use crate::tasks::TaskError;

/// Settings of the pool of targets.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TargetOptions {
    /// Number of points in the pool.
    pub pool: usize,
    /// Number of points drawn from the pool.
    pub drawn: usize,
    /// Source of the candidates: a sweep of the real robot, finer than the pool. Its nodes differ
    /// from the points of the error model.
    pub sweep: GridOptions,
}

impl Default for TargetOptions {
    fn default() -> Self {
        let sweep = GridOptions { rows: 61, columns: 61, max_pull_m: 0.03, max_step_m: 0.003 };
        TargetOptions { pool: 960, drawn: 50, sweep }
    }
}

impl TargetOptions {
    /// Checks every range.
    ///
    /// # Errors
    /// [`BadOption`] names the first field out of range.
    pub fn check(&self) -> Result<(), BadOption> {
        self.sweep.check()?;
        BadOption::unless_counted("drawn", self.drawn)?;
        if self.drawn > self.pool {
            return Err(BadOption {
                key: "drawn",
                found: self.drawn.to_string(),
                expected: "at most `pool`",
            });
        }
        let nodes = self.sweep.rows * self.sweep.columns;
        if self.pool > nodes {
            let found = format!("{} for a sweep of {nodes} nodes", self.pool);
            return Err(BadOption {
                key: "pool",
                found,
                expected: "at most the nodes of the sweep",
            });
        }
        Ok(())
    }
}

/// The pool: tips of a sweep of the robot, thinned to `options.pool` equally spaced ones. Use the
/// real robot without measurement noise, so that every target can be reached. The seed is the
/// plant's.
///
/// # Errors
/// [`TaskError`] for a setting out of range, a pool larger than the sweep, or a plant that fails.
pub fn target_pool(
    robot: &mut dyn Plant,
    options: &TargetOptions,
    seed: Seed,
) -> Result<Vec<Point3>, TaskError> {
    options.check()?;
    let map = BendMap::of(robot)?;
    let mut robot = RetryLostFrames(robot);
    let mut tip_m = robot.reset(seed.child("target_pool"))?.tip_m;
    let mut bend_m = map.straight();
    let mut candidates = Vec::with_capacity(options.sweep.rows * options.sweep.columns);
    for point_m in options.sweep.bends_m(&map) {
        if let Some(observation) =
            drive_to(&mut robot, &map, &mut bend_m, point_m, options.sweep.max_step_m)?
        {
            tip_m = observation.tip_m;
        }
        candidates.push(tip_m);
    }
    spread_targets(&candidates, options.pool)
}

/// `count` of the candidates, as equally spaced as possible: each next one is the farthest from all
/// before it (Gonzalez 1985), starting with the first; the earlier of equals. O(count ×
/// candidates).
///
/// # Errors
/// [`TaskError::TooFew`] when there are fewer than `count` distinct candidates.
pub fn spread_targets(candidates: &[Point3], count: usize) -> Result<Vec<Point3>, TaskError> {
    BadOption::unless_counted("pool", count)?;
    let mut gap_squared = vec![f64::INFINITY; candidates.len()];
    let mut chosen = Vec::with_capacity(count);
    let mut next = 0;
    while chosen.len() < count {
        if candidates.is_empty() || gap_squared[next] <= 0.0 {
            // A gap of zero means that all distinct candidates are chosen.
            let what = "distinct candidates for targets";
            return Err(TaskError::TooFew { what, required: count, available: chosen.len() });
        }
        let newest = candidates[next];
        chosen.push(newest);
        let mut farthest = 0;
        for (index, candidate) in candidates.iter().enumerate() {
            let squared: f64 = candidate.iter().zip(newest).map(|(a, b)| (a - b) * (a - b)).sum();
            gap_squared[index] = gap_squared[index].min(squared);
            if gap_squared[index] > gap_squared[farthest] {
                farthest = index;
            }
        }
        next = farthest;
    }
    Ok(chosen)
}

/// Draws `count` targets with their indices in the pool. The seed is the experiment's: every policy
/// gets the same targets in the same order, and a smaller draw is the beginning of a larger one.
///
/// # Errors
/// [`TaskError::TooFew`] when the pool is smaller.
pub fn draw_targets(
    pool: &[Point3],
    count: usize,
    seed: Seed,
) -> Result<Vec<(usize, Point3)>, TaskError> {
    if count > pool.len() {
        return Err(TaskError::TooFew {
            what: "targets in the pool",
            required: count,
            available: pool.len(),
        });
    }
    let mut order: Vec<usize> = (0..pool.len()).collect();
    // A shuffle of all, not a draw of some: smaller draws are beginnings of larger ones.
    order.shuffle(&mut seed.child("targets").rng());
    Ok(order.into_iter().take(count).map(|index| (index, pool[index])).collect())
}
