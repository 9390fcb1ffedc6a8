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
    /// How long it had waited when the controller was held, s: a held controller reads no lines.
    held_after_s: Option<f64>,
}

impl PendingLine {
    pub(super) fn new(line: String, purpose: LinePurpose, now_s: f64) -> PendingLine {
        PendingLine { line, sent_s: now_s, purpose, held_after_s: None }
    }

    /// How long it has waited for its answer, s. The time stands still during a hold.
    pub(super) fn waited_s(&self, now_s: f64) -> f64 {
        self.held_after_s.unwrap_or(now_s - self.sent_s)
    }

    /// The controller is held from now on.
    pub(super) fn hold(&mut self, now_s: f64) {
        self.held_after_s.get_or_insert(now_s - self.sent_s);
    }

    /// The controller goes on, and reads the line only now.
    pub(super) fn resume(&mut self, now_s: f64) {
        (self.sent_s, self.held_after_s) = (now_s, None);
    }
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
