//! Commands of a rig: checked against the limits and the state, then sent as moves.

use super::Rig;
use crate::hardware::axes::AXES;
use crate::hardware::grbl::{self, MotionFault};
use crate::hardware::safety::{CommandRefusal, GuardState, SafetyLimits};

/// Share of a tick that a move takes at full speed; the rest is for acceleration.
const MOVING_SHARE: f64 = 0.8;
/// Slowest feed that is sent, mm/min: a controller refuses 0.
const MIN_FEED_MM_MIN: f64 = 6.0;
/// Shorter moves are not sent, millimetres: they would round to nothing.
const MIN_MOVE_MM: f64 = 5e-4;

/// Share of `tracking_hold_s` above which the age of the last pose delays a command: the hold that
/// is about to come would leave the move without an answer.
const MAX_POSE_AGE_SHARE: f64 = 0.5;

/// Speed that every axis must reach for the largest step in `duration_s`, mm/min.
pub fn slowest_axis_mm_min(limits: &SafetyLimits, duration_s: f64) -> f64 {
    limits.step_m(duration_s) * 1e3 / (MOVING_SHARE * duration_s) * 60.0
}

/// Acceleration that every axis must reach for the largest step in `duration_s`, mm/s²: it speeds up
/// and slows down in the rest of the tick.
pub fn min_acceleration_mm_s2(limits: &SafetyLimits, duration_s: f64) -> f64 {
    // A move of length s at speed v takes s / v + v / a from rest to rest.
    let speed_mm_s = slowest_axis_mm_min(limits, duration_s) / 60.0;
    speed_mm_s / ((1.0 - MOVING_SHARE) * duration_s)
}

/// Why a command was not executed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MoveError {
    /// It exceeds a limit; nothing was sent and the robot stays where it is.
    #[error(transparent)]
    Refused(#[from] CommandRefusal),
    /// The motor driver refused the move.
    #[error(transparent)]
    RefusedByDriver(grbl::MoveRefusal),
    /// The controller's motion queue is full.
    #[error("motion queue full (2 moves pending)")]
    Busy,
    /// The last pose is so old that the robot is about to be held.
    #[error("the last valid pose is {:.0} ms old, expected a newer one before a move", age_s * 1e3)]
    OldPose {
        /// Its age, s.
        age_s: f64,
    },
    /// The robot is not active.
    #[error("the robot is {0}")]
    NotActive(&'static str),
    /// The controller is in an alarm whose cause a person has to remove; nothing was sent.
    #[error("the controller is in alarm {0}: {meaning} Then start the program again.", meaning = grbl::codes::alarm(*.0))]
    Alarm(u16),
}

impl MoveError {
    /// True if the same command may be accepted a moment later.
    pub fn is_temporary(&self) -> bool {
        matches!(self, MoveError::Busy | MoveError::OldPose { .. } | MoveError::NotActive(_))
    }
}

impl Rig {
    /// Moves the tendons to `pulls_m` in about `duration_s`, if the limits and the state of the
    /// robot permit it.
    ///
    /// # Errors
    /// [`MoveError`]: nothing was sent.
    pub fn command(
        &mut self,
        pulls_m: &[f64],
        duration_s: f64,
        now_s: f64,
    ) -> Result<(), MoveError> {
        self.check_command(pulls_m, duration_s)?;
        let target: [f64; AXES] = std::array::from_fn(|axis| pulls_m[axis]);
        self.send_move(target, duration_s, now_s)
    }

    /// Checks whether [`Rig::command`] would execute a command.
    ///
    /// # Errors
    /// [`MoveError`].
    pub fn check_command(&self, pulls_m: &[f64], duration_s: f64) -> Result<(), MoveError> {
        if *self.state() != GuardState::Active {
            return Err(MoveError::NotActive(self.state().name()));
        }
        Ok(self.parts.limits.check_command(pulls_m, &self.commanded_m, duration_s, 1)?)
    }

    /// Moves all tendons towards home by at most one step; true once they are there. From the
    /// switches the way home is longer than any permitted displacement, so the travel limit does
    /// not apply.
    ///
    /// # Errors
    /// [`MoveError`]: nothing was sent.
    pub fn step_towards_home(&mut self, duration_s: f64, now_s: f64) -> Result<bool, MoveError> {
        if *self.state() != GuardState::Active {
            return Err(MoveError::NotActive(self.state().name()));
        }
        let limits = &self.parts.limits;
        let step_m = limits.step_m(duration_s);
        let largest_m =
            self.commanded_m.iter().fold(0.0_f64, |largest, pull| largest.max(pull.abs()));
        // All tendons shrink by one share, so that opposite ones stay in balance.
        let share = if largest_m > step_m { 1.0 - step_m / largest_m } else { 0.0 };
        self.send_move(self.commanded_m.map(|pull| pull * share), duration_s, now_s)?;
        Ok(share == 0.0)
    }

    /// Refuses a move shortly before the robot is held for lost tracking.
    fn check_pose_age(&self, now_s: f64) -> Result<(), MoveError> {
        let age_s = self.parts.tracking.age_s(now_s);
        let max_age_s = MAX_POSE_AGE_SHARE * self.parts.limits.tracking_hold_s;
        // An age that is not a number delays the move, too.
        if age_s <= max_age_s { Ok(()) } else { Err(MoveError::OldPose { age_s }) }
    }

    fn send_move(
        &mut self,
        pulls_m: [f64; AXES],
        duration_s: f64,
        now_s: f64,
    ) -> Result<(), MoveError> {
        let (from_mm, to_mm) =
            (self.parts.machine_mm(&self.commanded_m), self.parts.machine_mm(&pulls_m));
        let length_mm =
            from_mm.iter().zip(&to_mm).map(|(from, to)| (to - from).powi(2)).sum::<f64>().sqrt();
        if length_mm >= MIN_MOVE_MM {
            self.check_pose_age(now_s)?;
            // GRBL's feed is along the path in all four axes.
            let feed_mm_min = (length_mm / (MOVING_SHARE * duration_s) * 60.0).max(MIN_FEED_MM_MIN);
            match self.parts.controller.move_to(to_mm, feed_mm_min, now_s) {
                Ok(()) => {}
                // A controller that was held reports so until its next status report.
                Err(MotionFault::Busy | MotionFault::Refused(grbl::MoveRefusal::NotReady(_))) => {
                    return Err(MoveError::Busy);
                }
                Err(MotionFault::Refused(refusal)) => {
                    return Err(MoveError::RefusedByDriver(refusal));
                }
                // The next poll finds the same fault and handles it.
                Err(_) => return Err(MoveError::NotActive("without a working controller")),
            }
        }
        // Only after success: a refused move leaves the last command in force.
        self.commanded_m = pulls_m;
        Ok(())
    }
}
