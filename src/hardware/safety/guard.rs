//! The state machine between whoever decides and whatever moves (docs/hardware.md shows it). It knows no device: it is
//! told what is the case and says what has to be done.

use std::collections::VecDeque;

use super::limits::SafetyLimits;

/// Why a robot is held or stopped, in words: what was found and what was expected.
#[derive(Clone, Debug, PartialEq)]
pub struct StopReason {
    /// One word for tables: `tracking`, `controller`, `tip`, `interrupted`, `ended`.
    pub kind: &'static str,
    /// What happened.
    pub what: String,
    /// How to go on.
    pub remedy: String,
}

/// What the robot may do.
#[derive(Clone, Debug, PartialEq)]
pub enum GuardState {
    /// Nothing moves: not homed yet.
    Idle,
    /// The axes look for their switches.
    Homing,
    /// Commands within the limits are carried out.
    Active,
    /// Motion is paused where it is and goes on once the reason is gone.
    Held {
        /// Why.
        reason: StopReason,
        /// Since when, seconds.
        since_s: f64,
    },
    /// Motion has ended; nothing moves until somebody has looked at the robot and armed it again.
    Stopped {
        /// Why.
        reason: StopReason,
        /// Since when, seconds.
        since_s: f64,
    },
}

impl GuardState {
    /// Name for tables and logs.
    pub fn name(&self) -> &'static str {
        match self {
            GuardState::Idle => "idle",
            GuardState::Homing => "homing",
            GuardState::Active => "active",
            GuardState::Held { .. } => "held",
            GuardState::Stopped { .. } => "stopped",
        }
    }
}

/// What is the case at one moment.
#[derive(Clone, Debug, Default)]
pub struct SafetyInputs {
    /// Why the motion cannot be trusted any more; nothing while it can.
    pub motion_fault: Option<StopReason>,
    /// Why the robot should not go on for now, such as a measurement that is old, invalid or implausible.
    pub hold_reason: Option<StopReason>,
    /// A request to end, such as Ctrl-C.
    pub interrupted: Option<StopReason>,
    /// Homing has ended well.
    pub homed: bool,
    /// A hold has come to its end: every axis stands.
    pub standing: bool,
}

/// What has to be done about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SafetyAction {
    /// Nothing.
    Nothing,
    /// Pause motion.
    Hold,
    /// Go on with it.
    Resume,
    /// Forget all motion that is queued; the robot stands.
    Flush,
}

/// The state machine.
#[derive(Clone, Debug)]
pub struct Guard {
    limits: SafetyLimits,
    state: GuardState,
    /// Since when a stopped robot has queued motion that has yet to be forgotten.
    stopping_s: Option<f64>,
    /// When it was last held.
    holds_s: VecDeque<f64>,
}

/// Longest that the axes are waited for until they stand, before their queue is forgotten, seconds: a reset of axes that
/// still slow down loses their position.
const STAND_S: f64 = 1.0;
/// The same where the motors cannot be trusted, nor their position.
const STAND_ANYWAY_S: f64 = 0.15;
/// The last so many seconds are those in which a robot may be held `most_holds` times.
const HOLDS_S: f64 = 10.0;

impl Guard {
    /// A guard of a robot that has not been homed.
    pub fn new(limits: SafetyLimits) -> Guard {
        Guard { limits, state: GuardState::Idle, stopping_s: None, holds_s: VecDeque::new() }
    }

    /// What the robot may do.
    pub fn state(&self) -> &GuardState {
        &self.state
    }

    /// Homing begins, where it may.
    pub fn begin_homing(&mut self) -> bool {
        let may = matches!(self.state, GuardState::Idle | GuardState::Active);
        if may {
            self.state = GuardState::Homing;
        }
        may
    }

    /// A robot that has been homed before becomes active.
    pub fn activate(&mut self) -> bool {
        let may = matches!(self.state, GuardState::Idle);
        if may {
            self.state = GuardState::Active;
        }
        may
    }

    /// A robot that stands and is not told to move for now, such as while somebody works on it: what the tracker sees does
    /// not matter until it becomes active again.
    pub fn park(&mut self) -> bool {
        let may = matches!(self.state, GuardState::Active);
        if may {
            self.state = GuardState::Idle;
        }
        may
    }

    /// The program ends: a robot that may move is stopped, one that homes as well.
    pub fn request_stop(&mut self, reason: StopReason, now_s: f64) -> SafetyAction {
        match self.state {
            GuardState::Idle | GuardState::Stopped { .. } => SafetyAction::Nothing,
            GuardState::Homing | GuardState::Active | GuardState::Held { .. } => self.stop(reason, now_s),
        }
    }

    /// Whether queued motion of a stopped robot has yet to be forgotten.
    pub fn is_stopping(&self) -> bool {
        self.stopping_s.is_some()
    }

    /// What the facts at `now_s` call for.
    pub fn evaluate(&mut self, facts: &SafetyInputs, now_s: f64) -> SafetyAction {
        if let GuardState::Stopped { .. } = self.state {
            return self.finish_stop(facts, now_s);
        }
        // A fault outlives the program, a request to end does not.
        if let Some(reason) = facts.motion_fault.as_ref().or(facts.interrupted.as_ref()) {
            return self.stop(reason.clone(), now_s);
        }
        match (&self.state, &facts.hold_reason) {
            (GuardState::Homing, _) if facts.homed => self.enter(GuardState::Active, SafetyAction::Nothing),
            (GuardState::Active, Some(reason)) => self.hold(reason.clone(), now_s),
            (GuardState::Held { .. }, None) => self.enter(GuardState::Active, SafetyAction::Resume),
            (GuardState::Held { since_s, .. }, Some(reason)) if now_s - since_s >= self.limits.hold_stop_s => {
                let reason = reason.clone();
                self.stop(reason, now_s)
            }
            _ => SafetyAction::Nothing,
        }
    }

    /// A robot that is held again and again is not one that goes on.
    fn hold(&mut self, reason: StopReason, now_s: f64) -> SafetyAction {
        self.holds_s.retain(|&then_s| now_s - then_s < HOLDS_S);
        self.holds_s.push_back(now_s);
        let (count, most) = (self.holds_s.len(), self.limits.most_holds);
        if count > most {
            let what = format!("held {count} times within {HOLDS_S} s, expected at most {most}; now: {}", reason.what);
            return self.stop(StopReason { what, ..reason }, now_s);
        }
        self.enter(GuardState::Held { reason, since_s: now_s }, SafetyAction::Hold)
    }

    fn enter(&mut self, state: GuardState, order: SafetyAction) -> SafetyAction {
        self.state = state;
        order
    }

    /// A robot that homes cannot be paused: its motion is forgotten at once.
    fn stop(&mut self, reason: StopReason, now_s: f64) -> SafetyAction {
        let order = match self.state {
            GuardState::Homing => SafetyAction::Flush,
            _ => SafetyAction::Hold,
        };
        self.stopping_s = (order == SafetyAction::Hold).then_some(now_s);
        self.enter(GuardState::Stopped { reason, since_s: now_s }, order)
    }

    /// Once the axes stand, or should have for long, what is queued is forgotten, so that nothing starts again by itself.
    fn finish_stop(&mut self, facts: &SafetyInputs, now_s: f64) -> SafetyAction {
        let patience_s = if facts.motion_fault.is_some() { STAND_ANYWAY_S } else { STAND_S };
        match self.stopping_s {
            Some(since_s) if facts.standing || now_s - since_s >= patience_s => {
                self.stopping_s = None;
                SafetyAction::Flush
            }
            _ => SafetyAction::Nothing,
        }
    }
}
