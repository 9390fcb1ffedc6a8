//! A robot that is driven for a fixed time, with the tip as it is measured and as it is without
//! tracking noise.

use super::reach::TrialError;
use crate::base::{Observation, Outcome, Plant, Point3, Policy, Seed, distance_m};

/// A robot, and the same robot without tracking noise, where there is one: it gets the same
/// commands, and its tip is the true one.
pub struct WatchedRobot {
    /// The robot.
    pub plant: Box<dyn Plant>,
    /// The same robot measured without noise.
    pub quiet: Option<Box<dyn Plant>>,
}

/// The end of one control step.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WatchedStep {
    pub(crate) time_s: f64,
    /// Not a number where tracking was lost.
    pub(crate) measured_m: Point3,
    /// As measured where no robot without noise runs beside.
    pub(crate) true_m: Point3,
    pub(crate) target_m: Point3,
    pub(crate) pulls_m: Vec<f64>,
}

impl WatchedStep {
    pub(crate) fn error_m(&self) -> f64 {
        distance_m(&self.true_m, &self.target_m)
    }

    pub(crate) fn tracked_m(&self) -> f64 {
        distance_m(&self.measured_m, &self.target_m)
    }
}

/// A run: the tip at home, the steps until the end or a failure, and `ok` or that failure.
pub(crate) struct WatchedRun {
    pub(crate) home_m: Point3,
    pub(crate) steps: Vec<WatchedStep>,
    pub(crate) status: Outcome,
}

impl WatchedRun {
    /// Distance travelled by all tendons together, metres, from home on.
    pub(crate) fn tendon_travel_m(&self) -> f64 {
        let home_m = self.steps.first().map(|step| vec![0.0; step.pulls_m.len()]);
        let pulls_m: Vec<&Vec<f64>> =
            home_m.iter().chain(self.steps.iter().map(|step| &step.pulls_m)).collect();
        let travel = |pair: &[&Vec<f64>]| -> f64 {
            pair[0].iter().zip(pair[1]).map(|(from, to)| (to - from).abs()).sum()
        };
        pulls_m.windows(2).map(travel).sum()
    }
}

impl WatchedRobot {
    /// Runs a policy from rest at home for one step for each target. In open loop it sees home
    /// alone.
    pub(crate) fn run(
        &mut self,
        policy: &mut dyn Policy,
        targets_m: impl Iterator<Item = Point3>,
        open: bool,
        seed: Seed,
    ) -> WatchedRun {
        let mut run = WatchedRun { home_m: [f64::NAN; 3], steps: Vec::new(), status: Outcome::Ok };
        run.status = Outcome::from(&self.play(policy, targets_m, open, seed, &mut run));
        run
    }

    fn play(
        &mut self,
        policy: &mut dyn Policy,
        targets_m: impl Iterator<Item = Point3>,
        open: bool,
        seed: Seed,
        run: &mut WatchedRun,
    ) -> Result<(), TrialError> {
        policy.reset();
        let home = self.plant.reset(seed)?;
        run.home_m = match &mut self.quiet {
            // The same seed for both: all other randomness is shared.
            Some(quiet) => quiet.reset(seed)?.tip_m,
            None => home.tip_m,
        };
        let mut observation = home.clone();
        for target_m in targets_m {
            let action = policy.act(if open { &home } else { &observation }, &target_m)?;
            observation = self.plant.step(&action.pulls_m)?;
            let measured_m = measured(&observation);
            let true_m = match &mut self.quiet {
                // Both robots get the same command, so that only tracking noise separates them.
                Some(quiet) => quiet.step(&action.pulls_m)?.tip_m,
                None => measured_m,
            };
            let pulls_m = action.pulls_m;
            run.steps.push(WatchedStep {
                time_s: observation.time_s,
                measured_m,
                true_m,
                target_m,
                pulls_m,
            });
        }
        Ok(())
    }
}

fn measured(observation: &Observation) -> Point3 {
    if observation.valid { observation.tip_m } else { [f64::NAN; 3] }
}
