//! A decision from outside behind what every policy has: the last valid measurement and the limits
//! of the drive.

use crate::base::{Action, Displacements, Observation, Point3, Policy, PolicyError, distance_m};
use crate::policies::PolicyOptions;
use crate::policies::parts::actuator_limits::{ActuatorLimits, largest_change_m};
use crate::policies::parts::tip_tracker::TipTracker;

/// What a policy from outside sees in a tick.
#[derive(Clone, Copy, Debug)]
pub struct OutsideView<'a> {
    /// Last valid measurement of the tip, metres.
    pub tip_m: Point3,
    /// Target, metres.
    pub target_m: Point3,
    /// Its last command, as limited; before the first one the displacements observed, metres.
    pub pulls_m: &'a [f64],
    /// Time since the trial began, seconds.
    pub time_s: f64,
}

/// What a policy from outside decides.
#[derive(Clone, Debug, PartialEq)]
pub struct OutsideDecision {
    /// Displacement of each tendon, metres.
    pub pulls_m: Displacements,
    /// Whether it will not change its command for this target any more; `None`: told from tip and
    /// command.
    pub settled: Option<bool>,
}

/// A user-defined policy.
pub trait OutsideDecider: Send {
    /// The displacements of the next sample that it takes of the robot before its trials, metres;
    /// see [`Policy::sample`].
    ///
    /// # Errors
    /// [`PolicyError`] where it fails.
    fn sample(&mut self, _seen: &Observation) -> Result<Option<Displacements>, PolicyError> {
        Ok(None)
    }

    /// A new trial begins.
    ///
    /// # Errors
    /// [`PolicyError`] where it fails.
    fn reset(&mut self) -> Result<(), PolicyError>;

    /// One control tick.
    ///
    /// # Errors
    /// [`PolicyError`] where it fails or decides something that is no command.
    fn decide(&mut self, view: &OutsideView) -> Result<OutsideDecision, PolicyError>;
}

/// A change of command below this is none, metres.
const COMMAND_TOLERANCE_M: f64 = 1e-5;

/// A decider behind the limits.
pub(super) struct OutsideController {
    decider: Box<dyn OutsideDecider>,
    /// Settled when the tip is this near to its target, metres.
    settled_m: f64,
    tip_tracker: TipTracker,
    limits: ActuatorLimits,
    last_m: Option<Displacements>,
    /// A failure to begin the trial, told at its first tick.
    failed: Option<PolicyError>,
}

impl OutsideController {
    pub(super) fn new(
        decider: Box<dyn OutsideDecider>,
        settled_m: f64,
        options: &PolicyOptions,
    ) -> Self {
        OutsideController {
            decider,
            settled_m,
            tip_tracker: TipTracker::default(),
            limits: ActuatorLimits::new(options.limits),
            last_m: None,
            failed: None,
        }
    }
}

impl Policy for OutsideController {
    fn sample(&mut self, seen: &Observation) -> Result<Option<Displacements>, PolicyError> {
        self.decider.sample(seen)
    }

    fn reset(&mut self) {
        self.failed = self.decider.reset().err();
        self.tip_tracker.reset();
        self.limits.reset();
        self.last_m = None;
    }

    fn act(&mut self, seen: &Observation, target_m: &Point3) -> Result<Action, PolicyError> {
        if let Some(failed) = &self.failed {
            return Err(failed.clone());
        }
        let reading = self.tip_tracker.read(seen, target_m)?;
        let pulls_m = self.last_m.as_deref().unwrap_or(&seen.pulls_m);
        let view =
            OutsideView { tip_m: reading.tip_m, target_m: *target_m, pulls_m, time_s: seen.time_s };
        let decision = self.decider.decide(&view)?;
        let limited = self.limits.apply(&decision.pulls_m, &seen.pulls_m)?;
        let settled = decision.settled.unwrap_or_else(|| {
            let near = reading.fresh && distance_m(&reading.tip_m, target_m) <= self.settled_m;
            near || largest_change_m(pulls_m, &decision.pulls_m) <= COMMAND_TOLERANCE_M
        });
        self.last_m = Some(limited.pulls_m.clone());
        Ok(Action { pulls_m: limited.pulls_m, settled: settled && limited.arrived, branch: "" })
    }
}
