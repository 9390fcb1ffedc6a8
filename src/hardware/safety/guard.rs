//! The state machine that holds and stops the robot (diagram in docs/reference/hardware.md).
//!
//! It knows no device. The rig gives it [`SafetyInputs`] every 5 ms and executes the
//! [`SafetyAction`] that [`Guard::evaluate`] returns. Lost tracking arrives as a `hold_reason`: the
//! robot is held at once, and stopped if it lasts for `hold_stop_s`.

use std::collections::VecDeque;

use super::limits::SafetyLimits;

/// Why a robot is held or stopped: what was found, what was expected, how to continue.
#[derive(Clone, Debug, PartialEq)]
pub struct StopReason {
    /// Kind, one word for tables: `tracking`, `controller`, `tip`, `interrupted`, `ended`.
    pub kind: &'static str,
    /// What happened.
    pub what: String,
    /// How to continue.
    pub remedy: String,
}

/// State of the robot.
#[derive(Clone, Debug, PartialEq)]
pub enum GuardState {
    /// Not homed; nothing moves.
    Idle,
    /// The axes are being homed.
    Homing,
    /// Commands within the limits are executed.
    Active,
    /// Motion is paused and resumes once the reason is gone.
    Held {
        /// Why.
        reason: StopReason,
        /// Since when, seconds.
        since_s: f64,
    },
    /// Motion has ended; nothing moves until a person has inspected the robot and armed it again.
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

/// What the guard decides on.
#[derive(Clone, Debug, Default)]
pub struct SafetyInputs {
    /// Fault of the motors, after which the motion cannot be trusted.
    pub motion_fault: Option<StopReason>,
    /// Why the robot has to be held now, such as a measurement that is old, invalid or implausible.
    pub hold_reason: Option<StopReason>,
    /// A request to end, such as Ctrl-C.
    pub interrupted: Option<StopReason>,
    /// Homing was successful.
    pub homed: bool,
    /// A hold is complete: every axis stands.
    pub standing: bool,
}

/// What the rig has to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SafetyAction {
    /// Nothing.
    Nothing,
    /// Pause motion.
    Hold,
    /// Resume motion.
    Resume,
    /// Discard all queued motion; the robot stands.
    Flush,
}

/// The state machine.
#[derive(Clone, Debug)]
pub struct Guard {
    limits: SafetyLimits,
    state: GuardState,
    /// Since when a stopped robot has queued motion that has yet to be discarded.
    stopping_s: Option<f64>,
    /// Times of the last holds.
    holds_s: VecDeque<f64>,
}

/// Longest time until the axes stand, s; then their queue is discarded all the same. A reset of
/// decelerating axes loses their position.
const STAND_S: f64 = 1.0;
/// The same after a fault of the motors, whose position cannot be trusted anyway.
const STAND_ANYWAY_S: f64 = 0.15;
/// Window in which a robot may be held `most_holds` times, s: a person who passes the cameras
/// causes one or two holds.
const HOLDS_S: f64 = 10.0;

impl Guard {
    /// A guard of a robot that has not been homed.
    pub fn new(limits: SafetyLimits) -> Guard {
        Guard { limits, state: GuardState::Idle, stopping_s: None, holds_s: VecDeque::new() }
    }

    /// State of the robot.
    pub fn state(&self) -> &GuardState {
        &self.state
    }

    /// Starts homing, if the state permits it.
    pub fn begin_homing(&mut self) -> bool {
        self.enter_if(
            matches!(self.state, GuardState::Idle | GuardState::Active),
            GuardState::Homing,
        )
    }

    /// Activates a robot that is homed.
    pub fn activate(&mut self) -> bool {
        self.enter_if(matches!(self.state, GuardState::Idle), GuardState::Active)
    }

    /// Parks a robot at rest, for example while a person works on it: tracking is ignored until it
    /// is active again.
    pub fn park(&mut self) -> bool {
        self.enter_if(matches!(self.state, GuardState::Active), GuardState::Idle)
    }

    /// Stops a robot that is active, held or homing, because the program ends or gives up.
    pub fn request_stop(&mut self, reason: StopReason, now_s: f64) -> SafetyAction {
        match self.state {
            GuardState::Idle | GuardState::Stopped { .. } => SafetyAction::Nothing,
            GuardState::Homing | GuardState::Active | GuardState::Held { .. } => {
                self.stop(reason, now_s)
            }
        }
    }

    /// Whether queued motion of a stopped robot has yet to be discarded.
    pub fn is_stopping(&self) -> bool {
        self.stopping_s.is_some()
    }

    /// Decides on the inputs at `now_s`: the next state and the action of the rig.
    pub fn evaluate(&mut self, inputs: &SafetyInputs, now_s: f64) -> SafetyAction {
        // A stop is final: no input leads out of it here.
        if let GuardState::Stopped { .. } = self.state {
            return self.finish_stop(inputs, now_s);
        }
        // A fault is remembered after the program ends, a request to end is not.
        if let Some(reason) = inputs.motion_fault.as_ref().or(inputs.interrupted.as_ref()) {
            return self.stop(reason.clone(), now_s);
        }
        match (&self.state, &inputs.hold_reason) {
            (GuardState::Homing, _) if inputs.homed => {
                self.enter(GuardState::Active, SafetyAction::Nothing)
            }
            (GuardState::Active, Some(reason)) => self.hold(reason.clone(), now_s),
            (GuardState::Held { .. }, None) => self.enter(GuardState::Active, SafetyAction::Resume),
            (GuardState::Held { since_s, .. }, Some(reason))
                if now_s - since_s >= self.limits.hold_stop_s =>
            {
                let reason = reason.clone();
                self.stop(reason, now_s)
            }
            _ => SafetyAction::Nothing,
        }
    }

    /// A robot that is held too often is stopped.
    fn hold(&mut self, reason: StopReason, now_s: f64) -> SafetyAction {
        self.holds_s.retain(|&then_s| now_s - then_s < HOLDS_S);
        self.holds_s.push_back(now_s);
        let (count, most) = (self.holds_s.len(), self.limits.most_holds);
        if count > most {
            let what = format!(
                "held {count} times within {HOLDS_S} s, expected at most {most}; last reason: {}",
                reason.what
            );
            return self.stop(StopReason { what, ..reason }, now_s);
        }
        self.enter(GuardState::Held { reason, since_s: now_s }, SafetyAction::Hold)
    }

    fn enter_if(&mut self, permitted: bool, state: GuardState) -> bool {
        if permitted {
            self.state = state;
        }
        permitted
    }

    fn enter(&mut self, state: GuardState, action: SafetyAction) -> SafetyAction {
        self.state = state;
        action
    }

    /// Homing cannot be paused: its motion is discarded at once.
    fn stop(&mut self, reason: StopReason, now_s: f64) -> SafetyAction {
        let action = match self.state {
            GuardState::Homing => SafetyAction::Flush,
            _ => SafetyAction::Hold,
        };
        self.stopping_s = (action == SafetyAction::Hold).then_some(now_s);
        self.enter(GuardState::Stopped { reason, since_s: now_s }, action)
    }

    /// Discards the queue once the axes stand, or should have for long, so that nothing starts
    /// again by itself.
    fn finish_stop(&mut self, inputs: &SafetyInputs, now_s: f64) -> SafetyAction {
        let patience_s = if inputs.motion_fault.is_some() { STAND_ANYWAY_S } else { STAND_S };
        match self.stopping_s {
            Some(since_s) if inputs.standing || now_s - since_s >= patience_s => {
                self.stopping_s = None;
                SafetyAction::Flush
            }
            _ => SafetyAction::Nothing,
        }
    }
}
