//! Goal reaching (section V-C): from rest at home to a target.

use serde::{Deserialize, Serialize};

use crate::base::{
    BadOption, Observation, Outcome, Plant, PlantError, Point3, Policy, PolicyError, Seed,
    distance_m,
};
use crate::tasks::TaskError;

/// Which observation the policy receives.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum LoopMode {
    /// Always the one before the first step.
    Open,
    /// The latest.
    #[default]
    Closed,
}

/// End of a trial and measurement of its error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ReachOptions {
    /// Largest number of control steps.
    pub max_steps: usize,
    /// Number of consecutive steps with a settled policy and a tip at rest that end the trial.
    pub settle_steps: usize,
    /// The tip is at rest when it moves by at most this in a step; `null`: only the policy counts.
    pub rest_m: Option<f64>,
    /// Further steps for which the last command is held before the error is measured.
    pub hold_steps: usize,
    /// Number of last measurements over which the distance from the target is averaged.
    pub averaged_samples: usize,
}

impl Default for ReachOptions {
    fn default() -> Self {
        ReachOptions {
            max_steps: 150,
            settle_steps: 3,
            rest_m: Some(0.002),
            hold_steps: 0,
            averaged_samples: 1,
        }
    }
}

impl ReachOptions {
    /// Checks every range.
    ///
    /// # Errors
    /// [`BadOption`] names the first field out of range.
    pub fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_counted("max_steps", self.max_steps)?;
        BadOption::unless_counted("settle_steps", self.settle_steps)?;
        BadOption::unless_counted("averaged_samples", self.averaged_samples)?;
        BadOption::unless_positive_or_null("rest_m", self.rest_m)
    }
}

/// The outcome of a trial.
#[derive(Clone, Debug, PartialEq)]
pub struct ReachOutcome {
    /// Last measured tip, metres; NaN without a measurement.
    pub tip_m: Point3,
    /// Distance from the target, metres, averaged over the last measurements.
    pub error_m: f64,
    /// Number of control steps, including holding.
    pub steps: usize,
    /// Whether the policy settled (and the tip came to rest) before the step limit.
    pub settled: bool,
    /// Number of changes between the controllers of a hybrid policy.
    pub switches: usize,
    /// A failed trial ends with its last measurement.
    pub status: Outcome,
}

/// A failure inside a trial.
#[derive(Debug, thiserror::Error)]
pub(crate) enum TrialError {
    #[error("plant: {0}")]
    Plant(#[from] PlantError),
    #[error("policy: {0}")]
    Policy(#[from] PolicyError),
}

/// Runs a trial. Open loop and load are properties of the observation and the plant, unknown to the
/// policy. The seed (measurement noise) belongs to the trial and is the same for every policy.
///
/// # Errors
/// [`TaskError::Option`] for a setting out of range. A plant or policy that fails is a status, not
/// an error.
pub fn reach(
    plant: &mut dyn Plant,
    policy: &mut dyn Policy,
    target_m: &Point3,
    mode: LoopMode,
    options: &ReachOptions,
    seed: Seed,
) -> Result<ReachOutcome, TaskError> {
    options.check()?;
    let mut trial = ReachRun { measured_m: Vec::new(), steps: 0, settled: false, switches: 0 };
    let result = trial.run(plant, policy, target_m, mode, options, seed);
    let tip_m = trial.measured_m.last().copied().unwrap_or([f64::NAN; 3]);
    // The mean of the last measurements, also of a trial that failed.
    let tail = &trial.measured_m[trial.measured_m.len().saturating_sub(options.averaged_samples)..];
    let error_m =
        tail.iter().map(|tip_m| distance_m(tip_m, target_m)).sum::<f64>() / tail.len() as f64;
    Ok(ReachOutcome {
        tip_m,
        error_m,
        steps: trial.steps,
        settled: trial.settled,
        switches: trial.switches,
        status: Outcome::from(&result),
    })
}

struct ReachRun {
    measured_m: Vec<Point3>,
    steps: usize,
    settled: bool,
    switches: usize,
}

impl ReachRun {
    fn run(
        &mut self,
        plant: &mut dyn Plant,
        policy: &mut dyn Policy,
        target_m: &Point3,
        mode: LoopMode,
        options: &ReachOptions,
        seed: Seed,
    ) -> Result<(), TrialError> {
        policy.reset();
        let home = plant.reset(seed)?;
        self.measured_m.push(home.tip_m);
        let mut observation = home.clone();
        let mut branch = None;
        let mut settled_steps = 0;
        while self.steps < options.max_steps && !self.settled {
            // Open loop: the policy keeps seeing the robot at home.
            let shown = if mode == LoopMode::Open { &home } else { &observation };
            let action = policy.act(shown, target_m)?;
            self.switches += usize::from(branch.is_some_and(|last| last != action.branch));
            branch = Some(action.branch);
            observation = self.step(plant, &action.pulls_m)?;
            // A policy may be content while the tip still swings.
            let settled = action.settled && self.at_rest(options.rest_m);
            settled_steps = if settled { settled_steps + 1 } else { 0 };
            self.settled = settled_steps >= options.settle_steps;
        }
        for _ in 0..options.hold_steps {
            let pulls_m = std::mem::take(&mut observation.pulls_m);
            observation = self.step(plant, &pulls_m)?;
        }
        plant.verify()?;
        Ok(())
    }

    fn step(&mut self, plant: &mut dyn Plant, pulls_m: &[f64]) -> Result<Observation, TrialError> {
        let observation = plant.step(pulls_m)?;
        self.steps += 1;
        // A lost frame must not stand as a measurement.
        if observation.valid {
            self.measured_m.push(observation.tip_m);
        }
        Ok(observation)
    }

    /// Whether the tip moved by no more than `rest_m` between the last two measurements.
    fn at_rest(&self, rest_m: Option<f64>) -> bool {
        let Some(rest_m) = rest_m else { return true };
        matches!(self.measured_m.as_slice(), [.., previous_m, latest_m] if distance_m(previous_m, latest_m) <= rest_m)
    }
}
