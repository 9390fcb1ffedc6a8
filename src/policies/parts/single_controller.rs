//! One controller and nothing beside it: what it sees of the robot, what it wants, what the drive
//! can do of that.

use super::actuator_limits::ActuatorLimits;
use super::tip_tracker::{TipReading, TipTracker};
use crate::base::{Action, Displacements, Observation, Point3, Policy, PolicyError};
use crate::policies::PolicyOptions;

/// What a controller wants before the drive's limits.
pub(crate) struct Demand {
    pub(crate) pulls_m: Displacements,
    pub(crate) settled: bool,
}

/// What decides, once a tick.
pub(crate) trait ControlLaw {
    /// Forgets the trial.
    fn reset(&mut self);

    /// One control tick.
    fn decide(&mut self, reading: TipReading, target_m: &Point3) -> Result<Demand, PolicyError>;
}

/// A controller behind the drive's limits.
pub(crate) struct SingleController<C> {
    controller: C,
    tip_tracker: TipTracker,
    limits: ActuatorLimits,
    branch: &'static str,
}

impl<C: ControlLaw> SingleController<C> {
    pub(crate) fn new(controller: C, branch: &'static str, options: &PolicyOptions) -> Self {
        SingleController {
            controller,
            tip_tracker: TipTracker::default(),
            limits: ActuatorLimits::new(options.limits),
            branch,
        }
    }
}

impl<C: ControlLaw + Send> Policy for SingleController<C> {
    fn reset(&mut self) {
        self.controller.reset();
        self.tip_tracker.reset();
        self.limits.reset();
    }

    fn act(&mut self, seen: &Observation, target_m: &Point3) -> Result<Action, PolicyError> {
        let reading = self.tip_tracker.read(seen, target_m)?;
        let demand = self.controller.decide(reading, target_m)?;
        let limited = self.limits.apply(&demand.pulls_m, &seen.pulls_m)?;
        Ok(Action {
            pulls_m: limited.pulls_m,
            settled: demand.settled && limited.arrived,
            branch: self.branch,
        })
    }
}
