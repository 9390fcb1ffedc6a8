//! What can go wrong with the motors, in words for whoever stands next to them.

use super::codes;
use super::state::{AXIS_NAMES, Mode};
use crate::base::BadOption;

/// Why a move was not sent. The controller goes on as before.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MoveRefusal {
    /// A target or a feed that is no number.
    #[error("a position or a feed that is not finite")]
    NotFinite,
    /// A target beyond the ends of a screw.
    #[error("axis {} to {target_mm} mm, its travel is {low_mm} to {high_mm} mm", AXIS_NAMES[*axis])]
    OutsideTravel {
        /// Axis, from 0.
        axis: usize,
        /// Where it was to go, mm.
        target_mm: f64,
        /// Lower end, mm.
        low_mm: f64,
        /// Upper end, mm.
        high_mm: f64,
    },
    /// A feed outside its range.
    #[error("a feed of {feed_mm_min} mm/min, expected 0.1 to {most_mm_min}")]
    Feed {
        /// Feed asked for, mm/min.
        feed_mm_min: f64,
        /// Largest feed allowed, mm/min.
        most_mm_min: f64,
    },
    /// The controller does not know where the axes are.
    #[error("the axes are not homed")]
    NotHomed,
    /// The controller is doing something else.
    #[error("the controller is not ready: {0}")]
    NotReady(Mode),
}

/// Why the motors cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MotionFault {
    /// Two moves are waiting already, or a line has not been answered yet. Try again after the next poll.
    #[error("the controller has enough to do, try again later")]
    Busy,
    /// Nothing was sent.
    #[error("move refused: {0}")]
    Refused(#[from] MoveRefusal),
    /// A setting of this program.
    #[error(transparent)]
    BadSettings(#[from] BadOption),
    /// The serial line is gone.
    #[error("the serial line to the controller is gone ({detail}); plug it in, then connect and home again")]
    Unplugged {
        /// What the system said.
        detail: String,
    },
    /// No answer in time.
    #[error(
        "the controller has not answered to {to} for {waited_s:.2} s; check its power and its cable, then reset and home \
         it again"
    )]
    Silent {
        /// What was not answered.
        to: String,
        /// Time since it was sent, seconds.
        waited_s: f64,
    },
    /// Homing has not come to its end.
    #[error(
        "homing has not ended after {waited_s:.0} s; check that all axes can move and reach their switches, then reset \
         and home again"
    )]
    HomingTimeout {
        /// Time since it began, seconds.
        waited_s: f64,
    },
    /// Lines that are not GRBL.
    #[error(
        "{count} lines of the controller were not readable, the last one is {line:?}; check cable, baud rate and what is \
         connected, then reset and home again"
    )]
    Garbled {
        /// Number of such lines within ten seconds.
        count: usize,
        /// The last one, as far as it is text.
        line: String,
    },
    /// An `ok` that nothing asked for.
    #[error("the controller acknowledged a line that was not sent; it is out of step: reset and home it again")]
    StrayOk,
    /// The controller refused a line.
    #[error("the controller refused {line:?} with error {code}: {}", codes::error(*code))]
    Error {
        /// Number after `error:`.
        code: u16,
        /// The line that was refused.
        line: String,
    },
    /// The controller stopped.
    #[error("the controller stopped with alarm {code}: {}", codes::alarm(*code))]
    Alarm {
        /// Number after `ALARM:`, 0 when it gave none.
        code: u16,
    },
    /// The controller started again by itself.
    #[error(
        "the controller has restarted by itself ({greeting}) and lost its position; check its power supply, then reset \
         and home it again"
    )]
    Rebooted {
        /// What it said.
        greeting: String,
    },
    /// The controller is in a mode that this driver does not lead to.
    #[error("the controller is in the mode {mode}, which this program did not ask for; reset and home it again")]
    UnexpectedMode {
        /// The mode.
        mode: Mode,
    },
    /// Somebody has changed what all speeds are multiplied by.
    #[error(
        "the controller multiplies all speeds by {percent} %; set its feed override to 100 %, then reset and home again"
    )]
    Override {
        /// Per cent.
        percent: f64,
    },
    /// An axis stays where it is.
    #[error(
        "axis {} stands at {reached_mm:.3} mm and should have gone to {target_mm:.3} mm; check motor, driver and \
         mechanics, then reset and home again", AXIS_NAMES[*axis]
    )]
    NotMoving {
        /// Axis, from 0.
        axis: usize,
        /// Where it is, mm.
        reached_mm: f64,
        /// Where it was sent, mm.
        target_mm: f64,
    },
    /// An axis is where no command put it.
    #[error(
        "axis {} is at {position_mm:.3} mm, its commands were between {low_mm:.3} and {high_mm:.3} mm; something else \
         moves it or the controller miscounts: reset and home again", AXIS_NAMES[*axis]
    )]
    Moved {
        /// Axis, from 0.
        axis: usize,
        /// Where it is, mm.
        position_mm: f64,
        /// Lowest position it was sent to, mm.
        low_mm: f64,
        /// Highest position it was sent to, mm.
        high_mm: f64,
    },
    /// An axis is beyond the ends of its screw.
    #[error(
        "axis {} is at {position_mm:.3} mm, its travel is {low_mm} to {high_mm} mm; reset and home again",
        AXIS_NAMES[*axis]
    )]
    OutsideTravel {
        /// Axis, from 0.
        axis: usize,
        /// Where it is, mm.
        position_mm: f64,
        /// Lower end, mm.
        low_mm: f64,
        /// Upper end, mm.
        high_mm: f64,
    },
    /// Positions would be counted from somewhere else than the switches.
    #[error("the controller has the work offset {found} in {name}, expected 0 everywhere; clear it with {remedy}")]
    WorkOffset {
        /// Coordinate system.
        name: String,
        /// The offset, mm.
        found: String,
        /// How to clear it.
        remedy: String,
    },
    /// Another firmware.
    #[error("the controller says {found:?} about its {what}, expected {expected}")]
    WrongFirmware {
        /// What was looked at.
        what: &'static str,
        /// What was found.
        found: String,
        /// What was expected.
        expected: &'static str,
    },
    /// A setting of the controller.
    #[error("setting ${number} ({meaning}) of the controller: found {found}, expected {expected}; set it by hand")]
    WrongSetting {
        /// Number of the setting.
        number: u16,
        /// What it is for.
        meaning: &'static str,
        /// Its value, `nothing` when there is none.
        found: String,
        /// What it must be.
        expected: String,
    },
}

impl MotionFault {
    /// The fault for an error of the serial line.
    pub(super) fn unplugged(error: &std::io::Error) -> MotionFault {
        MotionFault::Unplugged { detail: error.to_string() }
    }

    /// The fault for a status report without machine positions.
    pub(super) fn no_position() -> MotionFault {
        let found = "a report without MPos".to_owned();
        MotionFault::WrongFirmware { what: "status", found, expected: "the machine position of four axes" }
    }

    /// True when nothing was sent and nothing is broken: the caller may go on.
    pub fn is_refusal(&self) -> bool {
        matches!(self, MotionFault::Busy | MotionFault::Refused(_))
    }
}
