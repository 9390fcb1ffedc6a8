//! The interfaces of a control loop: plant and policy.

use super::line_peer::PeerError;
use super::observation::{Displacements, Observation, Point3};
use super::seed::Seed;
use super::tendon_layout::TendonLayout;

/// Command to one tendon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TendonCommand {
    /// Pull to this displacement, metres (positive pulls).
    Pull(f64),
    /// Follow the shape without slack and without tension; the observation reports the displacement
    /// this took.
    Follow,
}

impl TendonCommand {
    /// Its displacement, metres, or `following_m` where it follows.
    pub fn pull_m_or(self, following_m: f64) -> f64 {
        if let TendonCommand::Pull(pull_m) = self { pull_m } else { following_m }
    }
}

/// Why a plant could not execute a step.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlantError {
    /// The plant does not accept the command (not finite, wrong number of tendons, out of range).
    #[error("command refused: {0}")]
    Refused(String),
    /// The simulated mechanics found no equilibrium; holds the solver's named status.
    #[error("rod solver: {0}")]
    Solver(String),
    /// A real robot was stopped: why, and how to continue.
    #[error("robot stopped: {0}")]
    Stopped(String),
    /// A tick of a real robot was late, so that a row would not be measured at its time: by how
    /// much, and how to continue.
    #[error("tick late: {0}")]
    Late(String),
    /// The tip was not tracked, also when the command was repeated.
    #[error(
        "tracking lost: the tip was not tracked in {steps} further steps with the same command"
    )]
    Unseen {
        /// Number of repetitions.
        steps: usize,
    },
    /// The recording does not contain this command.
    #[error("not in the recording: {0}")]
    NotRecorded(String),
    /// The program that serves the robot does not answer as its protocol asks.
    #[error("robot server: {0}")]
    Server(#[from] PeerError),
}

/// A robot under control: simulated, replayed from a recording, or hardware.
pub trait Plant: Send {
    /// Number of tendons.
    fn tendons(&self) -> usize;
    /// Names of the tracked points besides the tip; their order is that of [`Observation::points`].
    fn points(&self) -> Vec<String> {
        Vec::new()
    }
    /// Which tendons bend which part, and where they lie; evenly around one segment where a plant
    /// does not know better.
    fn tendon_layout(&self) -> TendonLayout {
        TendonLayout::ring(self.tendons())
    }
    /// Duration of one step, seconds.
    fn step_s(&self) -> f64;
    /// Brings the robot to rest at home; `seed` starts the measurement noise.
    fn reset(&mut self, seed: Seed) -> Result<Observation, PlantError>;
    /// Applies the commands for one step and observes the robot at its end.
    fn drive(&mut self, commands: &[TendonCommand]) -> Result<Observation, PlantError>;
    /// Checks after a trial that what it measured can be trusted. A simulated robot needs no check.
    fn verify(&mut self) -> Result<(), PlantError> {
        Ok(())
    }
    /// [`Plant::drive`] with every tendon pulled to a displacement in metres.
    fn step(&mut self, pulls_m: &[f64]) -> Result<Observation, PlantError> {
        let commands: Vec<TendonCommand> =
            pulls_m.iter().map(|&pull_m| TendonCommand::Pull(pull_m)).collect();
        self.drive(&commands)
    }
}

/// Decision of a policy.
#[derive(Clone, Debug, PartialEq)]
pub struct Action {
    /// Displacement of each tendon, metres.
    pub pulls_m: Displacements,
    /// True when the policy will not change its command for this target any more.
    pub settled: bool,
    /// Controller that gave the command (`a` or `b`); empty for a single controller.
    pub branch: &'static str,
}

/// Why a policy gave no action.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PolicyError {
    /// An input or an output was not finite.
    #[error("not finite: {0}")]
    NotFinite(&'static str),
    /// Tracking was lost before anything had been measured.
    #[error("no valid measurement yet")]
    NoMeasurement,
    /// The model has a different number of tendons than the robot.
    #[error("wrong number of tendons: found {found}, expected {expected}")]
    Tendons {
        /// Number given.
        found: usize,
        /// Number that the robot has.
        expected: usize,
    },
    /// The policy asks a model, and the model has no plan: why.
    #[error("plan_failed: {0}")]
    PlanFailed(String),
    /// A policy from outside failed; its own words.
    #[error("{0}")]
    Outside(String),
}

impl PolicyError {
    /// Error unless all `values` are finite.
    pub fn unless_finite<'a>(
        what: &'static str,
        values: impl IntoIterator<Item = &'a f64>,
    ) -> Result<(), PolicyError> {
        if values.into_iter().all(|value| value.is_finite()) {
            Ok(())
        } else {
            Err(PolicyError::NotFinite(what))
        }
    }
}

/// A controller: maps observation and target to tendon displacements. It has no access to a plant.
pub trait Policy: Send {
    /// The displacements of the next sample, metres, that it takes of the robot before its trials,
    /// given the last one; none where it has enough, as a policy that learns nothing has.
    ///
    /// # Errors
    /// [`PolicyError`] where it fails.
    fn sample(&mut self, _seen: &Observation) -> Result<Option<Displacements>, PolicyError> {
        Ok(None)
    }
    /// Clears all state (a new trial begins).
    fn reset(&mut self);
    /// Decides the command for the next step, given the tip's target in metres.
    fn act(&mut self, seen: &Observation, target_m: &Point3) -> Result<Action, PolicyError>;
}
