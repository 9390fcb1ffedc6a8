//! Samples of a robot that a policy chooses before its trials, to learn from them.

use super::actuation::steps_between;
use super::retry_lost_frames::RetryLostFrames;
use crate::base::{Plant, PlantError, Policy, PolicyError, Seed};
use crate::tasks::TaskError;

/// Steps for which the robot rests under a command before its tip is measured: 1.6 s at the usual
/// 0.2 s, as for static poses.
const REST_STEPS: usize = 8;

/// Lets `policy` choose its samples: from each to the next the tendons move in even steps of at most
/// `max_step_m` metres, the robot rests, and the policy gets the measured tip. The first is at
/// home. Returns why the policy could take no more, where it failed; its trials show it, too.
///
/// # Errors
/// A plant that fails.
pub fn policy_samples(
    plant: &mut dyn Plant,
    policy: &mut dyn Policy,
    max_step_m: Option<f64>,
    seed: Seed,
) -> Result<Option<PolicyError>, TaskError> {
    let mut plant = RetryLostFrames(plant);
    let mut seen = plant.reset(seed)?;
    loop {
        let pulls_m = match policy.sample(&seen) {
            Ok(Some(pulls_m)) => pulls_m,
            Ok(None) => return Ok(None),
            Err(error) => return Ok(Some(error)),
        };
        let (found, expected) = (pulls_m.len(), seen.pulls_m.len());
        if found != expected {
            return Ok(Some(PolicyError::Tendons { found, expected }));
        }
        if let Err(error) = PolicyError::unless_finite("a sample", &pulls_m) {
            return Ok(Some(error));
        }
        let from_m = seen.pulls_m.clone();
        let moves = max_step_m.map_or(1, |step_m| steps_between(&from_m, &pulls_m, step_m)).max(1);
        for step in 1..=moves + REST_STEPS {
            let share = (step as f64 / moves as f64).min(1.0);
            let between_m: Vec<f64> =
                from_m.iter().zip(&pulls_m).map(|(from, to)| from + share * (to - from)).collect();
            match plant.step(&between_m) {
                Ok(observation) => seen = observation,
                // Out of the robot's travel: the policy learns of it, as its trials would.
                Err(PlantError::Refused(words)) => return Ok(Some(PolicyError::Outside(words))),
                Err(error) => return Err(error.into()),
            }
        }
    }
}
