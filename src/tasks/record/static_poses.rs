//! Static poses: the tendons move to each pose in even steps, the robot comes to rest, and several
//! measurements are averaged.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::actuation::steps_between;
use super::record_trial::measured_rows;
use crate::base::{BadOption, Observation, Plant, PlantError, Seed, SeenPoint};
use crate::data::{Actuation, Recording};

/// How static poses are recorded.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StaticPoseOptions {
    /// Largest change of a displacement in a step, metres.
    pub max_step_m: f64,
    /// Steps of waiting before the robot counts as at rest.
    pub rest_steps: usize,
    /// Number of measurements to average, one per step.
    pub looks: usize,
}

impl Default for StaticPoseOptions {
    fn default() -> Self {
        StaticPoseOptions { max_step_m: 0.003, rest_steps: 8, looks: 5 }
    }
}

impl StaticPoseOptions {
    /// Checks every range.
    ///
    /// # Errors
    /// [`BadOption`] names the first field out of range.
    pub fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("max_step_m", self.max_step_m)?;
        BadOption::unless_counted("looks", self.looks)
    }

    /// Steps from one pose to the next, including its measurements.
    fn steps(&self, from_m: &[f64], to_m: &[f64]) -> usize {
        steps_between(from_m, to_m, self.max_step_m) + self.rest_steps + self.looks
    }
}

/// Home, and bends in eight directions by `reach_m` and by half of it: displacements of the four
/// tendons, metres.
pub fn star_m(reach_m: f64) -> Vec<Vec<f64>> {
    let mut poses = vec![vec![0.0; 4]];
    for share in [0.5, 1.0] {
        for direction in 0..8 {
            let angle_rad = std::f64::consts::FRAC_PI_4 * f64::from(direction);
            let (x_m, y_m) = (share * reach_m * angle_rad.cos(), share * reach_m * angle_rad.sin());
            poses.push(vec![x_m, y_m, -x_m, -y_m]);
        }
    }
    poses
}

/// The commands for `poses_m` (displacements in metres; home is added as the first pose) under each
/// of the masses, kilograms: one trial for each mass, one row for each pose, at the time of its
/// last measurement.
pub fn plan_static_poses(
    poses_m: &[Vec<f64>],
    weights_kg: &[f64],
    options: &StaticPoseOptions,
    step_s: f64,
) -> Recording {
    let tendons = poses_m.first().map_or(4, Vec::len);
    let mut planned = Recording::new(Actuation::Lengths, tendons);
    let mut loads_kg = Vec::new();
    for (trial, &weight_kg) in (0..).zip(weights_kg) {
        let mut from_m = vec![0.0; tendons];
        let mut steps = 0;
        // Home comes first in any case; a second visit would tell nothing new.
        let bent_poses = poses_m.iter().filter(|pose| pose.iter().any(|&pull_m| pull_m != 0.0));
        for (number, pose) in std::iter::once(&vec![0.0; tendons]).chain(bent_poses).enumerate() {
            // The robot is already at rest at home.
            steps += if number == 0 { 0 } else { options.steps(&from_m, pose) };
            from_m.clone_from(pose);
            planned.trial.push(trial);
            planned.time_s.push(steps as f64 * step_s);
            planned.commands.push(pose);
            loads_kg.push(weight_kg);
        }
    }
    planned.known_load_kg = Some(loads_kg);
    planned
}

/// Records the poses of one trial of [`plan_static_poses`]. Each row is the averaged measurement of
/// a pose at rest under its own command.
///
/// # Errors
/// [`PlantError`] when the plant stops or refuses; the trial is lost.
pub fn record_static_poses(
    plant: &mut dyn Plant,
    planned: &Recording,
    rows: Range<usize>,
    options: &StaticPoseOptions,
    seed: Seed,
) -> Result<Recording, PlantError> {
    let mut from_m = vec![0.0; plant.tendons()];
    let mut observations = vec![plant.reset(seed)?];
    for row in rows.start + 1..rows.end {
        let to_m = planned.commands.row(row);
        let move_steps = steps_between(&from_m, to_m, options.max_step_m);
        for step in 1..=move_steps {
            let share = step as f64 / move_steps as f64;
            let pulls_m: Vec<f64> = from_m
                .iter()
                .zip(to_m)
                .map(|(from, to)| share * to + (1.0 - share) * from)
                .collect();
            plant.step(&pulls_m)?;
        }
        // The same number of steps for every pose, as planned: times must agree.
        for _ in 0..options.rest_steps {
            plant.step(to_m)?;
        }
        let looks: Vec<Observation> =
            (0..options.looks).map(|_| plant.step(to_m)).collect::<Result<_, _>>()?;
        from_m = to_m.to_vec();
        observations.push(averaged(looks));
    }
    plant.verify()?;
    Ok(measured_rows(planned, rows, &observations, &plant.points()))
}

/// The last of several observations, with the mean tip and points of the valid ones.
fn averaged(looks: Vec<Observation>) -> Observation {
    // Only the looks in which the tip was seen are averaged.
    let valid: Vec<[f64; 3]> =
        looks.iter().filter(|look| look.valid).map(|look| look.tip_m).collect();
    let tip_m = mean(&valid);
    let point = |index: usize| {
        let each =
            looks.iter().filter_map(|look| look.points.get(index)).map(|point| point.position_m);
        mean(
            &each.filter(|position_m| position_m.iter().all(|x| x.is_finite())).collect::<Vec<_>>(),
        )
    };
    let points_m: Vec<[f64; 3]> =
        (0..looks.first().map_or(0, |look| look.points.len())).map(point).collect();
    let last = looks.into_iter().last();
    let turns = last.iter().flat_map(|look| &look.points).map(|point| point.quaternion);
    let points = turns
        .zip(points_m)
        .map(|(quaternion, position_m)| SeenPoint { position_m, quaternion })
        .collect();
    let quaternion = last.as_ref().and_then(|look| look.tip_quaternion);
    let (time_s, pulls_m) = last.map_or((0.0, Vec::new()), |look| (look.time_s, look.pulls_m));
    let valid = !valid.is_empty();
    Observation {
        time_s,
        tip_m,
        tip_quaternion: quaternion,
        points,
        pulls_m,
        tensions_n: None,
        valid,
    }
}

/// The mean of some positions; not a number where there is none.
fn mean(positions_m: &[[f64; 3]]) -> [f64; 3] {
    let count = positions_m.len() as f64;
    std::array::from_fn(|axis| {
        positions_m.iter().map(|position_m| position_m[axis]).sum::<f64>() / count
    })
}
