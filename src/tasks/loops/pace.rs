//! A lap of the path in a given time: the target moves on with the clock.

use super::reach::LoopMode;
use super::watched::{WatchedRobot, WatchedStep};
use crate::base::{BadOption, Outcome, Point3, Policy, Seed, distance_m};
use crate::tasks::TaskError;

/// A lap. Lengths in metres.
#[derive(Clone, Debug, PartialEq)]
pub struct Lap {
    /// Root mean square of the distance from the moving target.
    pub rms_m: f64,
    /// Largest distance.
    pub largest_m: f64,
    /// Root mean square of the distance as it was measured.
    pub tracked_rms_m: f64,
    /// Distance travelled by all tendons together, the way to the first point included.
    pub tendon_travel_m: f64,
    /// `ok`, or the failure.
    pub status: Outcome,
}

/// Times of a lap, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LapTimes {
    /// Time at the first point of the path, before the lap.
    pub lead_in_s: f64,
    /// Time of the lap.
    pub lap_s: f64,
}

/// Runs a policy from rest at home: at the first point of the path for the lead-in, then once along
/// it at constant speed. Errors count in the lap alone.
///
/// # Errors
/// [`TaskError::Option`] for a time out of range, [`TaskError::TooFew`] for a path without length.
pub fn lap(
    robot: &mut WatchedRobot,
    policy: &mut dyn Policy,
    path_m: &[Point3],
    mode: LoopMode,
    LapTimes { lead_in_s, lap_s }: LapTimes,
    seed: Seed,
) -> Result<Lap, TaskError> {
    BadOption::unless_positive("lap_s", lap_s)?;
    BadOption::unless_positive("lead_in_s", lead_in_s)?;
    let step_s = robot.plant.step_s();
    let (lead_in_steps, lap_steps) =
        ((lead_in_s / step_s).round() as usize, (lap_s / step_s).round().max(1.0) as usize);
    let [first_m, _, ..] = path_m else {
        return Err(TaskError::TooFew {
            what: "points of the path",
            required: 2,
            available: path_m.len(),
        });
    };
    let targets_m = (1..=lap_steps).map(|tick| point_at(path_m, tick as f64 / lap_steps as f64));
    // The way from home is no part of the lap.
    let targets_m = std::iter::repeat_n(*first_m, lead_in_steps).chain(targets_m);
    let run = robot.run(policy, targets_m, mode == LoopMode::Open, seed);
    let lap = run.steps.get(lead_in_steps..).unwrap_or_default();
    Ok(Lap {
        rms_m: rms(lap, WatchedStep::error_m),
        // `f64::max` ignores NaN: lost frames do not count, and no frame at all leaves NaN.
        largest_m: lap.iter().map(WatchedStep::error_m).fold(f64::NAN, f64::max),
        tracked_rms_m: rms(lap, WatchedStep::tracked_m),
        tendon_travel_m: run.tendon_travel_m(),
        status: run.status,
    })
}

/// The point at a share of the length of a path.
fn point_at(path_m: &[Point3], share: f64) -> Point3 {
    let lengths_m: Vec<f64> =
        path_m.windows(2).map(|pair| distance_m(&pair[0], &pair[1])).collect();
    let mut remaining_m = share * lengths_m.iter().sum::<f64>();
    for (pair, length_m) in path_m.windows(2).zip(lengths_m) {
        if remaining_m <= length_m && length_m > 0.0 {
            return std::array::from_fn(|axis| {
                pair[0][axis] + remaining_m / length_m * (pair[1][axis] - pair[0][axis])
            });
        }
        remaining_m -= length_m;
    }
    path_m.last().copied().unwrap_or([f64::NAN; 3])
}

fn rms(steps: &[WatchedStep], error: fn(&WatchedStep) -> f64) -> f64 {
    let squares: Vec<f64> = steps
        .iter()
        .map(error)
        .filter(|error| error.is_finite())
        .map(|error| error * error)
        .collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_target_moves_at_constant_speed() {
        let path_m = [[0.0, 0.0, 0.0], [0.01, 0.0, 0.0], [0.01, 0.03, 0.0]];
        assert_eq!(point_at(&path_m, 0.25), [0.01, 0.0, 0.0]);
        assert!(distance_m(&point_at(&path_m, 0.5), &[0.01, 0.01, 0.0]) < 1e-12);
        assert!(distance_m(&point_at(&path_m, 1.0), &[0.01, 0.03, 0.0]) < 1e-12);
    }
}
