//! What is known of a controller.

use std::fmt;

/// Names of the axes in the order of every list of four.
pub const AXIS_NAMES: [char; 4] = ['X', 'Y', 'Z', 'A'];

/// What a controller is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Standing, ready for a move.
    Idle,
    /// Moving.
    Run,
    /// Held by `!`.
    Hold {
        /// True once it stands; a reset before that loses the position.
        complete: bool,
    },
    /// Jogging, which this driver never asks for.
    Jog,
    /// On the way to the switches.
    Home,
    /// Stopped by an alarm, with its number where it is known.
    Alarm(Option<u16>),
    /// A door switch is open.
    Door,
    /// Trying programs without moving.
    Check,
    /// Asleep.
    Sleep,
    /// Waiting for another tool.
    ToolChange,
    /// Not known yet.
    #[default]
    Unknown,
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Mode::Hold { complete: true } => f.write_str("Hold (standing)"),
            Mode::Hold { complete: false } => f.write_str("Hold (slowing down)"),
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

/// A controller as far as it has been heard.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ControllerState {
    /// What it is doing.
    pub mode: Mode,
    /// Where the axes stand by its count of steps, millimetres.
    pub position_mm: [f64; 4],
    /// True when that count starts at the switches.
    pub homed: bool,
    /// Inputs that are active.
    pub pins: Pins,
    /// Speed along the path, mm/min.
    pub feed_mm_min: f64,
    /// Lines sent that have not been answered.
    pub unacknowledged: usize,
    /// Moves in its queue, the running one included; never too few.
    pub queued: usize,
    /// When anything last arrived, seconds.
    pub last_reply_s: f64,
    /// When the last status report arrived, seconds.
    pub last_status_s: f64,
    /// Lines sent so far.
    pub sent: u64,
    /// Moves sent so far.
    pub moves: u64,
    /// Lines received that were no GRBL lines.
    pub garbled: u64,
    /// The last `[MSG:...]` that said something.
    pub message: String,
}
