//! Motors, tracker and guard of one robot: every command to the robot passes through [`Rig`].

mod motion;
mod plausibility;
mod stop_reasons;
mod tip_following;
mod tracking_loss;

pub use motion::{MoveError, min_acceleration_mm_s2, slowest_axis_mm_min};

use crate::base::{Point3, distance_m};

use super::axes::{AXES, AxesOptions};
use super::grbl::{Controller, Mode, codes};
use super::interrupt::Interrupt;
use super::safety::{
    Guard, GuardState, Latch, SafetyAction, SafetyInputs, SafetyLimits, StopReason,
};
use super::tracking::{TipPose, TrackerClient};
use plausibility::TipJump;
use stop_reasons::{
    ARM, ENDED, INTERRUPTED, controller_fault, interrupted, late_answer, program_ended,
};
use tip_following::TipFollowing;
use tracking_loss::LastPoseChange;

/// An event for the log.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// Time on the rig's clock, s.
    pub time_s: f64,
    /// The resulting state.
    pub state: &'static str,
    /// Kind of the reason for a hold or a stop; empty for other events.
    pub kind: &'static str,
    /// What happened and how to continue.
    pub what: String,
}

/// Components of a rig.
pub struct RigParts {
    /// The motors.
    pub controller: Controller,
    /// The tracker.
    pub tracking: TrackerClient,
    /// Screw positions at home.
    pub axes: AxesOptions,
    /// Limits of commands.
    pub limits: SafetyLimits,
    /// Answer time of the controller after which the robot is held, s.
    pub late_s: f64,
    /// Where a stop is stored; none in rehearsals.
    pub latch: Option<Latch>,
    /// Requests to end.
    pub interrupt: Interrupt,
}

impl RigParts {
    /// Displacements at the present axis positions, metres.
    fn pulls_m(&self) -> [f64; AXES] {
        self.axes.pulls_m(&self.controller.mirrored_mm(self.controller.state().position_mm))
    }

    /// Machine positions for displacements in metres, mm.
    fn machine_mm(&self, pulls_m: &[f64; AXES]) -> [f64; AXES] {
        self.controller.mirrored_mm(self.axes.from_switch_mm(pulls_m))
    }
}

/// Motors, tracker and guard.
pub struct Rig {
    parts: RigParts,
    guard: Guard,
    /// The last command, metres.
    commanded_m: [f64; AXES],
    /// Tip position that the model predicts, metres.
    expected_m: Option<Point3>,
    /// State when the tracker's pose last changed.
    last_pose_change: LastPoseChange,
    /// Whether the tip follows the screws.
    tip_following: TipFollowing,
    /// The last plausible pose of the tip.
    last_plausible: Option<TipPose>,
    /// A jump of the tip that has not been undone.
    jump: Option<TipJump>,
    events: Vec<Event>,
}

impl Rig {
    /// A rig that has not moved. If a stop has left the position unknown, homing is required.
    pub fn new(mut parts: RigParts) -> Rig {
        if parts.latch.as_ref().is_some_and(|latch| latch.homing_required().is_some()) {
            parts.controller.require_homing();
        }
        let commanded_m = parts.pulls_m();
        let guard = Guard::new(parts.limits);
        Rig {
            parts,
            guard,
            commanded_m,
            expected_m: None,
            last_pose_change: LastPoseChange::default(),
            tip_following: TipFollowing::default(),
            last_plausible: None,
            jump: None,
            events: Vec::new(),
        }
    }

    /// State of the guard.
    pub fn state(&self) -> &GuardState {
        self.guard.state()
    }

    /// Events so far.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// The motors.
    pub fn controller(&self) -> &Controller {
        &self.parts.controller
    }

    /// The tracker.
    pub fn tracking(&self) -> &TrackerClient {
        &self.parts.tracking
    }

    /// The last command, metres.
    pub fn commanded_m(&self) -> [f64; AXES] {
        self.commanded_m
    }

    /// Sets the tip position that the model predicts from now on, metres.
    pub fn set_expected_tip(&mut self, tip_m: Option<Point3>) {
        self.expected_m = tip_m;
    }

    /// Starts homing, or activates a robot that is homed. A controller that is in alarm is reset
    /// before it is homed.
    ///
    /// # Errors
    /// [`MoveError`]: nothing was sent.
    pub fn start(&mut self, now_s: f64) -> Result<(), MoveError> {
        let homed = self.parts.controller.homed();
        let alarm = self.parts.controller.alarm();
        if let Some(code) = alarm.filter(|&code| codes::needs_person(code)) {
            return Err(MoveError::Alarm(code));
        }
        // The guard is asked before anything is sent.
        let permitted = if homed { self.guard.activate() } else { self.guard.begin_homing() };
        if !permitted {
            return Err(MoveError::NotActive(self.state().name()));
        }
        if !homed {
            self.parts.controller.start_homing(now_s);
        }
        let message = match alarm {
            Some(code) => format!("reset to clear alarm {code}, homing"),
            None => if homed { "already homed" } else { "homing" }.to_owned(),
        };
        self.log_event(now_s, "", message);
        Ok(())
    }

    /// Releases a robot at rest for work on it, until [`Rig::start`]; false while it moves or is
    /// not active.
    pub fn park(&mut self, now_s: f64) -> bool {
        let parked = self.stands() && self.guard.park();
        if parked {
            self.expected_m = None;
            self.log_event(now_s, "", "parked".to_owned());
        }
        parked
    }

    /// Nothing moves and no move is pending.
    pub fn stands(&self) -> bool {
        let state = self.parts.controller.state();
        let done = state.mode == Mode::Idle && state.queued == 0 && state.unacknowledged == 0;
        done && !self.parts.controller.is_resuming()
    }

    /// Reads both devices, evaluates the guard and executes its action.
    pub fn poll(&mut self, now_s: f64) {
        // Both devices before the guard: it decides on the newest data.
        let motion = self.parts.controller.poll(now_s);
        self.parts.tracking.poll(now_s);
        let was_homing = *self.state() == GuardState::Homing;
        let inputs = SafetyInputs {
            motion_fault: motion.err().map(|fault| controller_fault(&fault)),
            hold_reason: self.hold_reason(now_s),
            interrupted: self.parts.interrupt.raised().then(interrupted),
            homed: self.parts.controller.homed() && !self.parts.controller.is_homing(),
            standing: self.parts.controller.stands(),
        };
        let before = self.state().name();
        let action = self.guard.evaluate(&inputs, now_s);
        self.apply_action(action, now_s);
        if was_homing && *self.state() == GuardState::Active {
            self.commanded_m = self.parts.pulls_m();
            self.clear_homing_required(now_s);
        }
        if self.state().name() != before {
            self.log_state(now_s);
        }
    }

    /// Why the robot has to be held now: the controller is late, tracking is lost, or the measured
    /// tip is implausible.
    fn hold_reason(&mut self, now_s: f64) -> Option<StopReason> {
        let waiting_s = self.parts.controller.waiting_s(now_s);
        if waiting_s > self.parts.late_s {
            return Some(late_answer(waiting_s));
        }
        self.tracking_loss(now_s).or_else(|| self.implausible_tip())
    }

    fn apply_action(&mut self, action: SafetyAction, now_s: f64) {
        match action {
            SafetyAction::Nothing => {}
            SafetyAction::Hold => self.parts.controller.hold(now_s),
            SafetyAction::Resume => self.parts.controller.resume(now_s),
            SafetyAction::Flush => {
                // A reset is the only way to empty the queue of a GRBL.
                self.parts.controller.reset(now_s);
                self.require_homing(now_s);
            }
        }
    }

    /// Axes that were reset before they stood may have lost steps: the next program has to know.
    fn require_homing(&mut self, now_s: f64) {
        let position_lost = self.parts.controller.homing_required();
        let latch = self
            .parts
            .latch
            .as_ref()
            .filter(|latch| position_lost && latch.homing_required().is_none());
        if let Some(Err(error)) =
            latch.map(|latch| latch.require_homing("reset while the axes were moving"))
        {
            self.log_event(now_s, "", format!("could not store that homing is required: {error}"));
        }
    }

    /// The axes have been homed.
    fn clear_homing_required(&mut self, now_s: f64) {
        if let Some(Err(error)) = self.parts.latch.as_ref().map(Latch::clear_homing_required) {
            self.log_event(now_s, "", format!("could not store that the axes are homed: {error}"));
        }
    }

    /// Stops a robot that did not execute a command in time, for later programs as well.
    pub fn stop(&mut self, what: String, now_s: f64) {
        self.stop_for(StopReason { kind: "controller", what, remedy: ARM.to_owned() }, now_s);
    }

    /// Stops the robot for `reason`, for later programs as well.
    pub fn stop_for(&mut self, reason: StopReason, now_s: f64) {
        let action = self.guard.request_stop(reason, now_s);
        self.apply_action(action, now_s);
        if action != SafetyAction::Nothing {
            self.log_state(now_s);
        }
    }

    /// Ends operation: a moving robot is held, and its queue is discarded at one of the next polls,
    /// as after a stop, so that the next program finds it at rest. False when there is nothing left
    /// to wait for.
    pub fn shut_down(&mut self, why: &str, now_s: f64) -> bool {
        // A robot at rest needs no stop.
        if !self.stands() || *self.state() == GuardState::Homing {
            let action = self.guard.request_stop(program_ended(why), now_s);
            self.apply_action(action, now_s);
            if action != SafetyAction::Nothing {
                self.log_state(now_s);
            }
        }
        self.guard.is_stopping()
    }

    /// The pose at `time_s`, interpolated between frames, if it is plausible.
    pub fn tip_at(&self, time_s: f64) -> Option<TipPose> {
        self.parts.tracking.pose_at(time_s).filter(|pose| self.is_plausible(pose))
    }

    fn is_plausible(&self, pose: &TipPose) -> bool {
        let near = |expected_m: &Point3| {
            distance_m(&pose.position_m, expected_m) <= self.parts.limits.tip_from_model_m
        };
        self.expected_m.as_ref().is_none_or(near)
    }

    /// Mean tip position since `since_s`, metres; none without tracking.
    pub fn mean_tip(&self, since_s: f64) -> Option<Point3> {
        self.parts.tracking.mean_since(since_s)
    }

    /// The last pose, if it was fresh enough at `time_s` not to hold the robot.
    pub fn fresh_tip(&self, time_s: f64) -> Option<TipPose> {
        let fresh = |pose: &&TipPose| time_s - pose.time_s <= self.parts.limits.tracking_hold_s;
        self.parts.tracking.latest().filter(fresh).filter(|pose| self.is_plausible(pose)).cloned()
    }

    /// Logs the present state.
    fn log_state(&mut self, now_s: f64) {
        let (kind, what) = match self.state() {
            GuardState::Held { reason, .. } => {
                (reason.kind, format!("{}; resumes automatically", reason.what))
            }
            GuardState::Stopped { reason, .. } => {
                let reason = reason.clone();
                let mut what = format!("{}; {}", reason.what, reason.remedy);
                // A program that ends regularly must not lock the robot for the next one.
                let latch = self
                    .parts
                    .latch
                    .as_ref()
                    .filter(|_| ![INTERRUPTED, ENDED].contains(&reason.kind));
                if let Some(Err(error)) = latch.map(|latch| latch.stop(&reason)) {
                    what = format!("{what}; could not store this stop for later programs: {error}");
                }
                (reason.kind, what)
            }
            state => ("", state.name().to_owned()),
        };
        self.log_event(now_s, kind, what);
    }

    fn log_event(&mut self, time_s: f64, kind: &'static str, what: String) {
        let state = self.state().name();
        if let Some(latch) = &self.parts.latch {
            // The log is informative only; the robot does not depend on it.
            let _ = latch.write(&format!("{time_s:10.3} s  {state:8} {kind:12} {what}"));
        }
        self.events.push(Event { time_s, state, kind, what });
    }
}
