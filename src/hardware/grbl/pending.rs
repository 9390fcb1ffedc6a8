//! The line that waits for its acknowledgement, and how far homing has come.

/// What a line that waits for its `ok` was sent for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LinePurpose {
    Setup,
    Move,
    Homing,
}

/// A line that has not been answered yet.
#[derive(Clone, Debug)]
pub(super) struct PendingLine {
    pub(super) line: String,
    pub(super) sent_s: f64,
    pub(super) purpose: LinePurpose,
}

/// How far homing has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum HomingPhase {
    /// Not homing.
    No,
    /// Starts as soon as the line is free.
    Wanted,
    /// The controller is homing.
    Running,
    /// Acknowledged; the next report tells the position.
    Settling,
}
