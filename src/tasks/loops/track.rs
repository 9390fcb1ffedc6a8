//! Closed-loop path tracking (section V-D): the target advances to the next point of the path when
//! the policy has settled.

use serde::{Deserialize, Serialize};

use super::reach::TrialError;
use crate::base::{BadOption, Outcome, Plant, Point3, Policy, Seed, distance_m};
use crate::tasks::TaskError;

/// When the target advances along the path.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TrackOptions {
    /// Largest number of steps for a point.
    pub max_steps_per_point: usize,
    /// Largest number of steps for the first point, which the robot reaches from rest at home.
    pub max_steps_first: usize,
    /// Number of consecutive steps with a settled policy after which the target advances.
    pub settle_steps: usize,
    /// Unless `null`, the target advances only when the measured tip is within this distance.
    pub within_m: Option<f64>,
}

impl Default for TrackOptions {
    fn default() -> Self {
        TrackOptions {
            max_steps_per_point: 100,
            max_steps_first: 150,
            settle_steps: 1,
            within_m: None,
        }
    }
}

impl TrackOptions {
    /// Checks every range.
    ///
    /// # Errors
    /// [`BadOption`] names the first field out of range.
    pub fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_counted("max_steps_per_point", self.max_steps_per_point)?;
        BadOption::unless_counted("max_steps_first", self.max_steps_first)?;
        BadOption::unless_counted("settle_steps", self.settle_steps)?;
        BadOption::unless_positive_or_null("within_m", self.within_m)
    }
}

/// One control step of a tracking run.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackStep {
    /// Number of the step, from 1.
    pub step: usize,
    /// Time at its end, seconds.
    pub time_s: f64,
    /// Index of the target on the path.
    pub path_point: usize,
    /// The target, metres.
    pub target_m: Point3,
    /// Displacements of the tendons during the step, metres; none in a step that failed.
    pub pulls_m: Vec<f64>,
    /// Measured tip at the end of the step, metres.
    pub tip_m: Point3,
    /// Distance of the tip from the target, metres.
    pub error_m: f64,
    /// Controller of a hybrid policy that gave the command.
    pub branch: &'static str,
    /// `ok`, or in the last step the failure that ended the run.
    pub status: Outcome,
}

/// Tracks `path_m` from rest at home. The run ends when the policy has settled at the last point,
/// when the steps for it are used up, or on a failure, which a last step names together with the
/// last measured tip.
///
/// # Errors
/// [`TaskError::Option`] for a setting out of range.
pub fn track(
    plant: &mut dyn Plant,
    policy: &mut dyn Policy,
    path_m: &[Point3],
    options: &TrackOptions,
    seed: Seed,
) -> Result<Vec<TrackStep>, TaskError> {
    options.check()?;
    let mut steps: Vec<TrackStep> = Vec::new();
    if let Err(error) = follow(plant, policy, path_m, options, seed, &mut steps) {
        // The failure becomes a last step, so that the table shows where it happened.
        let last = steps.last();
        let path_point = last.map_or(0, |step| step.path_point);
        let tip_m = last.map_or([f64::NAN; 3], |step| step.tip_m);
        let target_m = path_m.get(path_point).copied().unwrap_or([f64::NAN; 3]);
        steps.push(TrackStep {
            step: steps.len() + 1,
            time_s: last.map_or(0.0, |step| step.time_s),
            path_point,
            target_m,
            pulls_m: Vec::new(),
            tip_m,
            error_m: distance_m(&tip_m, &target_m),
            branch: last.map_or("", |step| step.branch),
            status: Outcome::Failed(error.to_string()),
        });
    }
    Ok(steps)
}

fn follow(
    plant: &mut dyn Plant,
    policy: &mut dyn Policy,
    path_m: &[Point3],
    options: &TrackOptions,
    seed: Seed,
    steps: &mut Vec<TrackStep>,
) -> Result<(), TrialError> {
    policy.reset();
    let mut observation = plant.reset(seed)?;
    for (path_point, target_m) in path_m.iter().enumerate() {
        // The way from home to the first point is longer than from point to point.
        let budget =
            if path_point == 0 { options.max_steps_first } else { options.max_steps_per_point };
        let mut settled_steps = 0;
        for _ in 0..budget {
            let action = policy.act(&observation, target_m)?;
            observation = plant.step(&action.pulls_m)?;
            let error_m = distance_m(&observation.tip_m, target_m);
            steps.push(TrackStep {
                step: steps.len() + 1,
                time_s: observation.time_s,
                path_point,
                target_m: *target_m,
                pulls_m: action.pulls_m,
                tip_m: observation.tip_m,
                error_m,
                branch: action.branch,
                status: Outcome::Ok,
            });
            let within = options.within_m.is_none_or(|within_m| error_m <= within_m);
            settled_steps = if action.settled && within { settled_steps + 1 } else { 0 };
            if settled_steps >= options.settle_steps {
                break;
            }
        }
    }
    plant.verify()?;
    Ok(())
}
