//! Checks around a trial that its rows can be trusted: the tip rests at home where it did before,
//! and every axis has moved its tendon.
//!
//! A controller counts steps. It knows neither of steps that a motor has lost nor of a body that has
//! moved on its mount.

use super::Hardware;
use super::axis_response::find_blocked;
use super::plant::stop_error;
use crate::base::{PlantError, Point3, distance_m};
use crate::hardware::safety::{GuardState, StopReason};

/// Longest time over which the tip at rest is averaged, s: enough for noise of 0.5 mm.
const MAX_AVERAGED_S: f64 = 0.25;

/// Largest motion of the tip at home since it rested there first, compared with that over one trial:
/// the creep of several trials adds up.
const MAX_CREEP_RATIO: f64 = 2.0;

/// Where the tip rested at home, metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct HomeTips {
    /// First under the present weight.
    first_m: Point3,
    /// Before and after the last trial.
    last_m: Point3,
}

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

    /// Compares the tip of a robot at rest at home with where it rested before the last trial, and
    /// first under the present weight. Without tracking nothing is compared; the guard holds the
    /// robot then.
    pub(super) fn check_home_tip(&mut self) -> Result<(), PlantError> {
        let since_s = self.now_s() - self.settle_s.min(MAX_AVERAGED_S);
        let Some(tip_m) = self.supervised.rig().mean_tip(since_s) else { return Ok(()) };
        let HomeTips { first_m, last_m } =
            self.home_tips.unwrap_or(HomeTips { first_m: tip_m, last_m: tip_m });
        self.home_tips = Some(HomeTips { first_m, last_m: tip_m });
        let tolerance_m = self.safety.home_tolerance_m;
        self.check_moved("before the trial", distance_m(&tip_m, &last_m), tolerance_m)?;
        let since_first_m = distance_m(&tip_m, &first_m);
        self.check_moved("at first", since_first_m, MAX_CREEP_RATIO * tolerance_m)
    }

    fn check_moved(&self, when: &str, moved_m: f64, max_m: f64) -> Result<(), PlantError> {
        if moved_m <= max_m {
            return Ok(());
        }
        Err(self.distrust(format!(
            "the rest position of the tip at home differs by {:.1} mm from that {when}, expected \
             at most {:.1} mm (safety.home_tolerance_m {}): a motor has lost steps, the tip's or \
             the base's body has moved on its mount, or a tendon has come off",
            moved_m * 1e3,
            max_m * 1e3,
            self.safety.home_tolerance_m
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
