//! The response to one target over a fixed time: speed, overshoot and what remains at the end.

use super::reach::LoopMode;
use super::watched::{WatchedRobot, WatchedRun, WatchedStep};
use crate::base::{BadOption, Outcome, Point3, Policy, Seed, distance_m};
use crate::tasks::TaskError;

/// The response to one target. Lengths in metres, times in seconds; not a number where there is
/// none.
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    /// Distance of the target from home.
    pub distance_m: f64,
    /// Time that the limit of the drive asks for from home to the last command.
    pub limit_s: f64,
    /// Times from which on the error stays within 5, 3 and 2 mm.
    pub within_s: [f64; 3],
    /// Errors after 1, 2 and 5 s.
    pub error_after_m: [f64; 3],
    /// Mean error in the last second.
    pub error_end_m: f64,
    /// The same as it was measured.
    pub tracked_end_m: f64,
    /// Largest distance past the target.
    pub overshoot_m: f64,
    /// Distance travelled by all tendons together.
    pub tendon_travel_m: f64,
    /// `ok`, or the failure.
    pub status: Outcome,
}

/// Bounds of [`Response::within_s`], metres.
const WITHIN_M: [f64; 3] = [0.005, 0.003, 0.002];
/// Times of [`Response::error_after_m`], seconds.
const AFTER_S: [f64; 3] = [1.0, 2.0, 5.0];
/// Rounding of times that are sums of steps, seconds.
const ROUNDING_S: f64 = 1e-6;

/// What limits a response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResponseLimits {
    /// Duration, seconds.
    pub duration_s: f64,
    /// How far a tendon moves in a tick, metres.
    pub max_step_m: Option<f64>,
}

/// Runs a policy from rest at home.
///
/// # Errors
/// [`TaskError::Option`] for a duration below one step. A plant or policy that fails is a status,
/// not an error.
pub fn response(
    robot: &mut WatchedRobot,
    policy: &mut dyn Policy,
    target_m: &Point3,
    mode: LoopMode,
    ResponseLimits { duration_s, max_step_m }: ResponseLimits,
    seed: Seed,
) -> Result<Response, TaskError> {
    let step_s = robot.plant.step_s();
    let steps = (duration_s / step_s + ROUNDING_S).floor();
    if !(1.0..=1e6).contains(&steps) {
        let found = duration_s.to_string();
        return Err(
            BadOption { key: "duration_s", found, expected: "at least one control step" }.into()
        );
    }
    let targets_m = std::iter::repeat_n(*target_m, steps as usize);
    let run = robot.run(policy, targets_m, mode == LoopMode::Open, seed);
    Ok(summarised(&run, target_m, step_s, max_step_m))
}

fn summarised(
    run: &WatchedRun,
    target_m: &Point3,
    step_s: f64,
    max_step_m: Option<f64>,
) -> Response {
    let complete = run.status.is_ok();
    let steps = &run.steps;
    let end_s = steps.last().map_or(0.0, |step| step.time_s);
    let last_second: Vec<&WatchedStep> =
        steps.iter().filter(|step| step.time_s > end_s - 1.0 + ROUNDING_S).collect();
    let mean = |error: fn(&WatchedStep) -> f64| {
        let errors: Vec<f64> =
            last_second.iter().map(|step| error(step)).filter(|error| error.is_finite()).collect();
        errors.iter().sum::<f64>() / errors.len() as f64
    };
    let after = |time_s: f64| steps.iter().find(|step| step.time_s >= time_s - ROUNDING_S);
    let furthest_m = steps.last().map_or(0.0, |step| {
        step.pulls_m.iter().fold(0.0_f64, |largest, pull| largest.max(pull.abs()))
    });
    // The farthest tendon decides: all move at once.
    let ticks = |max_step_m: f64| (furthest_m / max_step_m - ROUNDING_S).ceil().max(1.0);
    Response {
        distance_m: distance_m(&run.home_m, target_m),
        limit_s: max_step_m.map_or(f64::NAN, |max_step_m| step_s * ticks(max_step_m)),
        within_s: WITHIN_M
            .map(|within_m| if complete { settled_s(steps, within_m) } else { f64::NAN }),
        error_after_m: AFTER_S.map(|time_s| after(time_s).map_or(f64::NAN, WatchedStep::error_m)),
        error_end_m: mean(WatchedStep::error_m),
        tracked_end_m: mean(WatchedStep::tracked_m),
        overshoot_m: overshoot_m(run, target_m),
        tendon_travel_m: run.tendon_travel_m(),
        status: run.status.clone(),
    }
}

/// The end of the first step from which on the error stays within a bound.
fn settled_s(steps: &[WatchedStep], within_m: f64) -> f64 {
    let outside = |step: &WatchedStep| step.error_m().is_nan() || step.error_m() > within_m;
    // From the end: an early pass through the bound does not count as settled.
    let first_inside = steps.iter().rposition(outside).map_or(0, |last| last + 1);
    steps.get(first_inside).map_or(f64::NAN, |step| step.time_s)
}

/// How far the tip goes past the target along the line from home.
fn overshoot_m(run: &WatchedRun, target_m: &Point3) -> f64 {
    let line_m: Point3 = std::array::from_fn(|axis| target_m[axis] - run.home_m[axis]);
    let length_m = distance_m(target_m, &run.home_m);
    let past = |step: &WatchedStep| {
        (0..3)
            .map(|axis| (step.true_m[axis] - target_m[axis]) * line_m[axis] / length_m)
            .sum::<f64>()
    };
    run.steps.iter().map(past).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(tips_x_m: &[f64]) -> WatchedRun {
        let step = |(index, &x_m): (usize, &f64)| WatchedStep {
            time_s: 0.2 * (index + 1) as f64,
            measured_m: [x_m + 0.001, 0.0, 0.0],
            true_m: [x_m, 0.0, 0.0],
            target_m: [0.1, 0.0, 0.0],
            pulls_m: vec![0.003 * (index + 1) as f64, -0.003 * (index + 1) as f64],
        };
        let steps = tips_x_m.iter().enumerate().map(step).collect();
        WatchedRun { home_m: [0.0; 3], steps, status: Outcome::Ok }
    }

    #[test]
    fn times_count_from_when_the_error_stays_small() {
        let response = summarised(
            &run(&[0.05, 0.099, 0.106, 0.102, 0.0995, 0.0995]),
            &[0.1, 0.0, 0.0],
            0.2,
            Some(0.003),
        );
        let expected = [0.8, 0.8, 0.8];
        assert!(
            response.within_s.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9),
            "{response:?}"
        );
        assert!(
            (response.overshoot_m - 0.006).abs() < 1e-12
                && (response.distance_m - 0.1).abs() < 1e-12,
            "{response:?}"
        );
        assert!(
            (response.error_after_m[0] - 0.0005).abs() < 1e-12
                && response.error_after_m[1].is_nan(),
            "{response:?}"
        );
        assert!((response.tendon_travel_m - 0.036).abs() < 1e-12, "{response:?}");
        assert!((response.limit_s - 1.2).abs() < 1e-9, "six steps of 3 mm: {response:?}");
    }

    #[test]
    fn a_tip_that_leaves_again_was_never_there() {
        let response = summarised(&run(&[0.0999, 0.0999, 0.09]), &[0.1, 0.0, 0.0], 0.2, None);
        assert!(
            response.within_s.iter().all(|time_s| time_s.is_nan()) && response.limit_s.is_nan(),
            "{response:?}"
        );
    }
}
