//! Faults of the motors, described for the person at the robot.

use super::check;
use super::check::WrongSetting;
use super::codes;
use super::state::{AXIS_NAMES, Mode};
use crate::base::BadOption;

/// Why a move was not sent. The controller remains usable.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MoveRefusal {
    /// A target or a feed is not finite.
    #[error("a position or feed is not finite")]
    NotFinite,
    /// A target is beyond the ends of a screw.
    #[error("axis {}: target {target_mm} mm, expected {low_mm} to {high_mm} mm", AXIS_NAMES[*axis])]
    OutsideTravel {
        /// Axis, from 0.
        axis: usize,
        /// Requested position, mm.
        target_mm: f64,
        /// Lower end, mm.
        low_mm: f64,
        /// Upper end, mm.
        high_mm: f64,
    },
    /// A feed is out of range.
    #[error("feed {feed_mm_min} mm/min, expected 0.1 to {most_mm_min}")]
    Feed {
        /// Requested feed, mm/min.
        feed_mm_min: f64,
        /// Largest feed allowed, mm/min.
        most_mm_min: f64,
    },
    /// The axes are not homed.
    #[error("the axes are not homed")]
    NotHomed,
    /// The controller is in a mode that accepts no moves.
    #[error("the controller is in the mode {0}, expected Idle or Run")]
    NotReady(Mode),
}

/// Why the motors cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MotionFault {
    /// Two moves are pending, or a line has not been acknowledged yet. Try again after the next
    /// poll.
    #[error("motion queue full or line not acknowledged; try again later")]
    Busy,
    /// The move was refused; nothing was sent.
    #[error("move refused: {0}")]
    Refused(#[from] MoveRefusal),
    /// A setting of this program is out of range.
    #[error(transparent)]
    BadSettings(#[from] BadOption),
    /// The serial line is gone.
    #[error(
        "serial line to the controller lost ({detail}); reconnect the cable, then connect and home \
         again"
    )]
    Unplugged {
        /// Error of the operating system.
        detail: String,
    },
    /// The controller did not answer in time.
    #[error(
        "no answer of the controller to {to} within {waited_s:.2} s; check its power and its \
         cable, then reset and home it again"
    )]
    Silent {
        /// The line or query without an answer.
        to: String,
        /// Time since it was sent, s.
        waited_s: f64,
    },
    /// Bytes that are not GRBL arrived in place of an answer.
    #[error(
        "the serial line carries bytes that are not GRBL ({line:?}) in place of the answer to {to} \
         within {waited_s:.2} s; check the baud rate, the cable's shield and what is connected to \
         the port, then reset and home again"
    )]
    Noise {
        /// The line or query without an answer.
        to: String,
        /// The last of those bytes, decoded as far as possible.
        line: String,
        /// Time since the line or query was sent, s.
        waited_s: f64,
    },
    /// A hold that does not end.
    #[error(
        "the controller is in the mode {mode} {waited_s:.2} s after this program requested to \
         resume; `~` was sent {sent} times after the axes had stopped. Check its hold and door \
         inputs, then reset and home again"
    )]
    NotResumed {
        /// The mode.
        mode: Mode,
        /// Time since the wish to resume, s.
        waited_s: f64,
        /// Number of resume bytes sent.
        sent: u32,
    },
    /// Homing did not end in time.
    #[error(
        "homing did not end within {waited_s:.0} s; check that all axes can move and reach their \
         switches, then reset and home again"
    )]
    HomingTimeout {
        /// Time since homing began, s.
        waited_s: f64,
    },
    /// Received lines are not GRBL.
    #[error(
        "{count} lines of the controller are unreadable, the last one is {line:?}; check the \
         cable, the baud rate and the connected device, then reset and home again"
    )]
    Garbled {
        /// Number of such lines within ten seconds.
        count: usize,
        /// The last one, decoded as far as possible.
        line: String,
    },
    /// An `ok` arrived that no line was waiting for.
    #[error("the controller acknowledged a line that was not sent; reset and home it again")]
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
        /// Number after `ALARM:`, 0 if it gave none.
        code: u16,
    },
    /// The controller restarted by itself.
    #[error(
        "the controller restarted ({greeting}) and lost its position; check its power supply, then \
         reset and home it again"
    )]
    Rebooted {
        /// Its greeting.
        greeting: String,
    },
    /// The controller is in a mode that this driver never requests.
    #[error(
        "the controller is in the mode {mode}, which this program did not request; reset and home \
         it again"
    )]
    UnexpectedMode {
        /// The mode.
        mode: Mode,
    },
    /// The feed override is not 100 %.
    #[error(
        "feed override {percent} %, expected 100 %; set it to 100 %, then reset and home again"
    )]
    Override {
        /// The feed override, per cent.
        percent: f64,
    },
    /// An axis does not move.
    #[error(
        "axis {} does not move: position {reached_mm:.3} mm, target {target_mm:.3} mm; check \
         motor, driver and mechanics, then reset and home again", AXIS_NAMES[*axis]
    )]
    NotMoving {
        /// Axis, from 0.
        axis: usize,
        /// Position, mm.
        reached_mm: f64,
        /// Target, mm.
        target_mm: f64,
    },
    /// None of several axes moves.
    #[error(
        "no axis moves: position {reached_mm:.3?} mm, target {target_mm:.3?} mm; the motors are off \
         or do not turn: check their power supply, the enable input of their drivers and whether \
         the controller runs, then reset and home again"
    )]
    NoAxisMoves {
        /// Positions, mm.
        reached_mm: [f64; 4],
        /// Targets, mm.
        target_mm: [f64; 4],
    },
    /// An axis is at a position that no command led to.
    #[error(
        "axis {} is at {position_mm:.3} mm, expected {low_mm:.3} to {high_mm:.3} mm as commanded; \
         another program moves it or the controller miscounts: reset and home again", AXIS_NAMES[*axis]
    )]
    Moved {
        /// Axis, from 0.
        axis: usize,
        /// Position, mm.
        position_mm: f64,
        /// Lowest commanded position, mm.
        low_mm: f64,
        /// Highest commanded position, mm.
        high_mm: f64,
    },
    /// An axis is beyond the ends of its screw.
    #[error(
        "axis {} is at {position_mm:.3} mm, expected {low_mm} to {high_mm} mm; reset and home \
         again",
        AXIS_NAMES[*axis]
    )]
    OutsideTravel {
        /// Axis, from 0.
        axis: usize,
        /// Position, mm.
        position_mm: f64,
        /// Lower end, mm.
        low_mm: f64,
        /// Upper end, mm.
        high_mm: f64,
    },
    /// A work offset shifts the origin of the positions.
    #[error("work offset {found} in {name}, expected 0 on all axes; clear it with {remedy}")]
    WorkOffset {
        /// Coordinate system.
        name: String,
        /// The offset, mm.
        found: String,
        /// How to clear it.
        remedy: String,
    },
    /// The firmware is not supported.
    #[error("{what} of the controller: found {found:?}, expected {expected}")]
    WrongFirmware {
        /// The checked property.
        what: &'static str,
        /// What was found.
        found: String,
        /// What was expected.
        expected: &'static str,
    },
    /// Settings of the controller are wrong.
    #[error("{}", check::describe(_0))]
    WrongSettings(Vec<WrongSetting>),
}

impl MotionFault {
    /// The fault for an error of the serial line.
    pub(super) fn unplugged(error: &std::io::Error) -> MotionFault {
        MotionFault::Unplugged { detail: error.to_string() }
    }

    /// The fault for a status report without machine positions.
    pub(super) fn no_position() -> MotionFault {
        let found = "no MPos".to_owned();
        MotionFault::WrongFirmware {
            what: "status",
            found,
            expected: "the machine positions of four axes",
        }
    }

    /// True when nothing was sent and nothing is broken: the caller may continue.
    pub fn is_refusal(&self) -> bool {
        matches!(self, MotionFault::Busy | MotionFault::Refused(_))
    }
}
