//! State of a controller.

use std::fmt;

/// Names of the axes in the order of every list of four.
pub const AXIS_NAMES: [char; 4] = ['X', 'Y', 'Z', 'A'];

/// Alarm number for "homing required".
pub(super) const HOMING_REQUIRED: u16 = 11;

/// Mode of a controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// At rest, ready for a move.
    Idle,
    /// Moving.
    Run,
    /// Feed hold (`!`).
    Hold {
        /// True once the axes stand; a reset before that loses the position.
        complete: bool,
    },
    /// Jogging, which this driver never requests.
    Jog,
    /// Homing.
    Home,
    /// Alarm, with its number if known.
    Alarm(Option<u16>),
    /// A door switch is open.
    Door,
    /// Checking programs without moving.
    Check,
    /// Asleep.
    Sleep,
    /// Waiting for a tool change.
    ToolChange,
    /// Not known yet.
    #[default]
    Unknown,
}

impl Mode {
    /// This mode; an alarm without a number has that of `earlier`, if that is an alarm.
    pub(super) fn with_alarm_of(self, earlier: Mode) -> Mode {
        match (self, earlier) {
            (Mode::Alarm(None), Mode::Alarm(_)) => earlier,
            _ => self,
        }
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Mode::Hold { complete: true } => f.write_str("Hold (standing)"),
            Mode::Hold { complete: false } => f.write_str("Hold (decelerating)"),
            Mode::Alarm(Some(code)) => write!(f, "Alarm {code}"),
            Mode::Alarm(None) => f.write_str("Alarm"),
            Mode::ToolChange => f.write_str("tool change"),
            other => write!(f, "{other:?}"),
        }
    }
}

/// Inputs that are active.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pins {
    /// Limit switches of X, Y, Z and A.
    pub limits: [bool; 4],
    /// Any other input (door, probe, emergency stop, ...).
    pub other: bool,
}

impl Pins {
    /// From the letters of a status report.
    pub fn of_letters(letters: &str) -> Pins {
        let limits = AXIS_NAMES.map(|name| letters.contains(name));
        Pins { limits, other: letters.chars().any(|letter| !AXIS_NAMES.contains(&letter)) }
    }
}

/// State of a controller as last reported.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ControllerState {
    /// Its mode.
    pub mode: Mode,
    /// Positions of the axes by its step count, millimetres.
    pub position_mm: [f64; 4],
    /// True when positions count from the homing switches.
    pub homed: bool,
    /// Inputs that are active.
    pub pins: Pins,
    /// Speed along the path, mm/min.
    pub feed_mm_min: f64,
    /// Lines sent that have not been acknowledged.
    pub unacknowledged: usize,
    /// Moves in its queue, including the running one; never underestimated.
    pub queued: usize,
    /// When anything last arrived, seconds.
    pub last_reply_s: f64,
    /// When the last status report arrived, seconds.
    pub last_status_s: f64,
    /// Lines sent so far.
    pub sent: u64,
    /// Moves sent so far.
    pub moves: u64,
    /// Received lines that were not GRBL.
    pub garbled: u64,
    /// The last `[MSG:...]` with a text.
    pub message: String,
}
