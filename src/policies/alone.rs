//! One controller and nothing beside it: what it sees of the robot, what it wants, what the drive can do of that.

use super::PolicyOptions;
use super::limits::Limits;
use super::sight::{Glance, Sight};
use crate::base::{Action, Displacements, Observation, Point3, Policy, PolicyError};

/// What a controller wants before the drive's limits.
pub(super) struct Wanted {
    pub(super) pulls_m: Displacements,
    pub(super) settled: bool,
}

/// What decides, once a tick.
pub(super) trait Controller {
    /// Forgets the trial.
    fn reset(&mut self);

    /// One control tick.
    fn decide(&mut self, glance: Glance, target_m: &Point3) -> Result<Wanted, PolicyError>;
}

/// A controller behind the drive's limits.
pub(super) struct Alone<C> {
    controller: C,
    sight: Sight,
    limits: Limits,
    branch: &'static str,
}

impl<C: Controller> Alone<C> {
    pub(super) fn new(controller: C, branch: &'static str, options: &PolicyOptions) -> Self {
        Alone { controller, sight: Sight::default(), limits: Limits::new(options.limits), branch }
    }
}

impl<C: Controller + Send> Policy for Alone<C> {
    fn reset(&mut self) {
        self.controller.reset();
        self.sight.reset();
        self.limits.reset();
    }

    fn act(&mut self, seen: &Observation, target_m: &Point3) -> Result<Action, PolicyError> {
        let glance = self.sight.look(seen, target_m)?;
        let wanted = self.controller.decide(glance, target_m)?;
        let limited = self.limits.apply(&wanted.pulls_m, &seen.pulls_m)?;
        Ok(Action { pulls_m: limited.pulls_m, settled: wanted.settled && limited.arrived, branch: self.branch })
    }
}
