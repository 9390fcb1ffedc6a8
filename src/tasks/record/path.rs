//! The path of section V-D: "33 real data points in the workspace" connected "with linear
//! interpolation".

use serde::{Deserialize, Serialize};

use super::actuation::{BendMap, drive_to};
use super::retry_lost_frames::RetryLostFrames;
use crate::base::{BadOption, Plant, Point3, Seed, distance_m};
use crate::tasks::TaskError;

/// Settings of the path: a smooth closed curve in the actuation plane, r(φ) = radius (1 +
/// petal_share cos(petals φ)), driven on the real robot, whose tips at equal φ are the way-points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PathOptions {
    /// Way-points.
    pub points: usize,
    /// Mean pull along the curve.
    pub radius_m: f64,
    /// How much the pull varies along it, as a share of `radius_m` (0 is a circle).
    pub petal_share: f64,
    /// Number of periods of the variation in a turn.
    pub petals: u32,
    /// Whether the last way-point is connected to the first.
    pub closed: bool,
    /// Largest distance between interpolated points.
    pub spacing_m: f64,
    /// Largest change of either pull in a step along the curve.
    pub max_step_m: f64,
    /// Steps for which a way-point's command is held before it is measured.
    pub hold_steps: usize,
}

impl Default for PathOptions {
    fn default() -> Self {
        PathOptions {
            points: 33,
            radius_m: 0.02,
            petal_share: 0.3,
            petals: 3,
            closed: true,
            spacing_m: 0.002,
            max_step_m: 0.003,
            hold_steps: 5,
        }
    }
}

impl PathOptions {
    /// Checks every range.
    ///
    /// # Errors
    /// [`BadOption`] names the first field out of range.
    pub fn check(&self) -> Result<(), BadOption> {
        for (key, value) in [
            ("radius_m", self.radius_m),
            ("spacing_m", self.spacing_m),
            ("max_step_m", self.max_step_m),
        ] {
            BadOption::unless_positive(key, value)?;
        }
        if self.points < 2 {
            let found = self.points.to_string();
            return Err(BadOption {
                key: "points",
                found,
                expected: "a whole number of at least 2",
            });
        }
        if !(0.0..1.0).contains(&self.petal_share) {
            let found = self.petal_share.to_string();
            return Err(BadOption {
                key: "petal_share",
                found,
                expected: "a number from 0 to below 1",
            });
        }
        Ok(())
    }

    fn bend_m(&self, index: usize) -> [f64; 2] {
        let angle = std::f64::consts::TAU * index as f64 / self.points as f64;
        let radius_m =
            self.radius_m * (1.0 + self.petal_share * (f64::from(self.petals) * angle).cos());
        [radius_m * angle.cos(), radius_m * angle.sin()]
    }
}

/// Records the way-points on the real robot.
///
/// # Errors
/// [`TaskError`] for a setting out of range or a plant that fails.
pub fn waypoints(
    robot: &mut dyn Plant,
    options: &PathOptions,
    seed: Seed,
) -> Result<Vec<Point3>, TaskError> {
    options.check()?;
    let map = BendMap::of(robot)?;
    let mut robot = RetryLostFrames(robot);
    let mut tip_m = robot.reset(seed.child("path"))?.tip_m;
    let mut bend_m = map.straight();
    let mut points = Vec::with_capacity(options.points);
    for index in 0..options.points {
        if let Some(observation) = drive_to(
            &mut robot,
            &map,
            &mut bend_m,
            map.everywhere(options.bend_m(index)),
            options.max_step_m,
        )? {
            tip_m = observation.tip_m;
        }
        for _ in 0..options.hold_steps {
            tip_m = robot.drive(&map.commands(&bend_m))?.tip_m;
        }
        points.push(tip_m);
    }
    Ok(points)
}

/// Connects way-points by straight lines, each divided into equal pieces of at most
/// `options.spacing_m`. Every way-point is on the path; a closed path ends at its first point.
///
/// # Errors
/// [`TaskError`] for a setting out of range.
pub fn interpolate(waypoints: &[Point3], options: &PathOptions) -> Result<Vec<Point3>, TaskError> {
    options.check()?;
    let Some(first) = waypoints.first() else { return Ok(Vec::new()) };
    let closing = options.closed.then_some(first);
    let mut path = vec![*first];
    for (from, to) in waypoints.iter().zip(waypoints.iter().skip(1).chain(closing)) {
        let pieces = (distance_m(from, to) / options.spacing_m).ceil().max(1.0);
        // The last piece ends at the way-point, which is added without rounding.
        for piece in 1..(pieces as usize) {
            let share = piece as f64 / pieces;
            path.push(std::array::from_fn(|axis| from[axis] + share * (to[axis] - from[axis])));
        }
        path.push(*to);
    }
    Ok(path)
}
