//! Checks around a trial that its rows can be trusted: the tip rests at home where it did first,
//! and every axis has moved its tendon.
//!
//! A controller counts steps. It knows neither of steps that a motor has lost nor of a body that has
//! moved on its mount.

use super::Hardware;
use super::axis_response::find_blocked;
use super::plant::stop_error;
use crate::base::{PlantError, distance_m};
use crate::hardware::safety::{GuardState, StopReason};

/// Longest time over which the tip at rest is averaged, s: enough for noise of 0.5 mm.
const MAX_AVERAGED_S: f64 = 0.25;

impl Hardware {
    /// Brings the robot home and lets it rest there, unless it does already.
    pub(super) fn rest_at_home(&mut self) -> Result<(), PlantError> {
        if self.rests_at_home && *self.supervised.rig().state() == GuardState::Active {
            return Ok(());
        }
        self.go_home()?;
        self.model.home()?;
        let (events, rested_s) = (self.event_count(), self.now_s() + self.settle_s);
        self.supervised.clock.sleep_until(rested_s);
        self.wait_until_active(events, rested_s + self.patience_s)?;
        self.rests_at_home = true;
        Ok(())
    }

    /// Compares the tip of a robot at rest at home with where it rested first under the present
    /// weight. Without tracking nothing is compared; the guard holds the robot then.
    pub(super) fn check_home_tip(&mut self) -> Result<(), PlantError> {
        let since_s = self.now_s() - self.settle_s.min(MAX_AVERAGED_S);
        let Some(tip_m) = self.supervised.rig().mean_tip(since_s) else { return Ok(()) };
        let first_m = *self.first_home_m.get_or_insert(tip_m);
        let (moved_m, tolerance_m) = (distance_m(&tip_m, &first_m), self.safety.home_tolerance_m);
        if moved_m <= tolerance_m {
            return Ok(());
        }
        Err(self.distrust(format!(
            "the tip rests at home {:.1} mm from where it rested first, expected at most {:.1} mm \
             (safety.home_tolerance_m): a motor has lost steps, the tip's or the base's body has \
             moved on its mount, or a tendon has come off",
            moved_m * 1e3,
            tolerance_m * 1e3
        )))
    }

    /// Looks for an axis that has not moved its tendon in the present trial.
    pub(super) fn check_axes(&mut self) -> Result<(), PlantError> {
        match find_blocked(&self.model, &self.trial, self.step_s) {
            Some(blocked) => Err(self.distrust(blocked.to_string())),
            None => Ok(()),
        }
    }

    /// Stops the robot, whose position is unknown.
    fn distrust(&self, what: String) -> PlantError {
        let remedy = "check bodies, motors and tendons with `spinebench doctor --move` after \
                      `spinebench arm --plant PLANT.yaml`"
            .to_owned();
        let message = format!("{what}; {remedy}");
        let now_s = self.now_s();
        let mut rig = self.supervised.rig();
        rig.stop_for(StopReason { kind: "tip", what, remedy }, now_s);
        stop_error(rig.state()).unwrap_or(PlantError::Stopped(message))
    }
}
