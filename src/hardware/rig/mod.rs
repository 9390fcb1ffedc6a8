//! Motors, tracker and guard of one robot: everything that leaves goes through here.

pub(crate) mod plausibility;
pub(crate) mod stop_reasons;

use crate::base::{Point3, distance_m};

use super::axes::{AXES, AxesOptions};
use super::grbl::{self, Controller, Mode, MotionFault};
use super::interrupt::Interrupt;
use super::safety::{CommandRefusal, Guard, GuardState, Latch, SafetyAction, SafetyInputs, SafetyLimits, StopReason};
use super::tracking::{TipPose, TrackerClient};
use plausibility::LastPoseChange;
use stop_reasons::{ARM, ENDED, INTERRUPTED, controller_fault, interrupted, program_ended};

/// Share of a tick that a move takes at full speed; the rest is for its acceleration.
const MOVING_SHARE: f64 = 0.8;
/// Slowest feed that is sent, mm/min: a controller takes none of 0.
const MIN_FEED_MM_MIN: f64 = 6.0;
/// Moves shorter than this are not sent, millimetres: they would round to nothing.
const MIN_MOVE_MM: f64 = 5e-4;

/// Speed that every axis must be able to reach for the largest step in `duration_s`, mm/min.
pub fn slowest_axis_mm_min(limits: &SafetyLimits, duration_s: f64) -> f64 {
    limits.step_m(duration_s) * 1e3 / (MOVING_SHARE * duration_s) * 60.0
}

/// Something that happened, for the log.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// When, on the rig's clock, seconds.
    pub time_s: f64,
    /// The state that it led to.
    pub state: &'static str,
    /// Kind of the cause of a hold or a stop; empty for anything else.
    pub kind: &'static str,
    /// What happened and how to go on.
    pub what: String,
}

/// Why a command was not carried out.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MoveError {
    /// Beyond a limit; nothing left and the robot stays where it is.
    #[error(transparent)]
    Refused(#[from] CommandRefusal),
    /// The last gate before the wire refused it.
    #[error(transparent)]
    RefusedByDriver(grbl::MoveRefusal),
    /// The controller's queue is full for now.
    #[error("the controller has two moves to do already")]
    Busy,
    /// Not active.
    #[error("the robot is {0}")]
    NotActive(&'static str),
}

/// What a rig is made of.
pub struct RigParts {
    /// The motors.
    pub controller: Controller,
    /// The tracker.
    pub tracking: TrackerClient,
    /// Where the screws stand at home.
    pub axes: AxesOptions,
    /// The limits.
    pub limits: SafetyLimits,
    /// A robot whose controller has owed an answer for so long is held, s.
    pub late_s: f64,
    /// Where a stop is kept; none in rehearsals.
    pub latch: Option<Latch>,
    /// Requests to end.
    pub interrupt: Interrupt,
}

impl RigParts {
    /// Displacements as the axes stand, metres.
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
    /// The command in force, metres.
    commanded_m: [f64; AXES],
    /// Where the model puts the tip, metres.
    expected_m: Option<Point3>,
    /// What things were like when the tracker's pose last changed.
    last_pose_change: LastPoseChange,
    /// The last tip that was believed, with its time.
    last_plausible: Option<(f64, Point3)>,
    events: Vec<Event>,
}

impl Rig {
    /// A rig that has not moved. Where a stop has left the position in doubt, the axes have to be homed.
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
            last_plausible: None,
            events: Vec::new(),
        }
    }

    /// What the robot may do.
    pub fn state(&self) -> &GuardState {
        self.guard.state()
    }

    /// What has happened so far.
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

    /// The command in force, metres.
    pub fn commanded_m(&self) -> [f64; AXES] {
        self.commanded_m
    }

    /// Where the model puts the tip from now on, metres.
    pub fn set_expected_tip(&mut self, tip_m: Option<Point3>) {
        self.expected_m = tip_m;
    }

    /// Sends the axes to their switches, or makes a robot active that knows where it is.
    pub fn start(&mut self, now_s: f64) -> Result<(), MoveError> {
        let homed = self.parts.controller.homed();
        let may = if homed { self.guard.activate() } else { self.guard.begin_homing() };
        if !may {
            return Err(MoveError::NotActive(self.state().name()));
        }
        if !homed {
            self.parts.controller.start_homing(now_s);
        }
        self.log_event(now_s, "", if homed { "already homed" } else { "homing" }.to_owned());
        Ok(())
    }

    /// Leaves a robot that stands to whoever works on it, until [`Rig::start`]; false while it moves or may not.
    pub fn park(&mut self, now_s: f64) -> bool {
        let parked = self.stands() && self.guard.park();
        if parked {
            self.expected_m = None;
            self.log_event(now_s, "", "parked".to_owned());
        }
        parked
    }

    /// Nothing moves and nothing is about to.
    fn stands(&self) -> bool {
        let state = self.parts.controller.state();
        state.mode == Mode::Idle && state.queued == 0 && state.unacknowledged == 0
    }

    /// Reads what has arrived and does what it calls for.
    pub fn poll(&mut self, now_s: f64) {
        let motion = self.parts.controller.poll(now_s);
        self.parts.tracking.poll(now_s);
        let was_homing = *self.state() == GuardState::Homing;
        let facts = SafetyInputs {
            motion_fault: motion.err().map(|fault| controller_fault(&fault)),
            hold_reason: self.hold_reason(now_s),
            interrupted: self.parts.interrupt.raised().then(interrupted),
            homed: self.parts.controller.homed() && !self.parts.controller.is_homing(),
            standing: self.parts.controller.stands(),
        };
        let before = self.state().name();
        let action = self.guard.evaluate(&facts, now_s);
        self.apply_action(action, now_s);
        if was_homing && *self.state() == GuardState::Active {
            self.commanded_m = self.parts.pulls_m();
            self.clear_homing_required(now_s);
        }
        if self.state().name() != before {
            self.log_state(now_s);
        }
    }

    fn apply_action(&mut self, action: SafetyAction, now_s: f64) {
        match action {
            SafetyAction::Nothing => {}
            SafetyAction::Hold => self.parts.controller.hold(now_s),
            SafetyAction::Resume => self.parts.controller.resume(now_s),
            SafetyAction::Flush => {
                self.parts.controller.reset(now_s);
                self.require_homing(now_s);
            }
        }
    }

    /// Axes that were reset before they stood may have lost steps, which the next program has to know.
    fn require_homing(&mut self, now_s: f64) {
        let tracking_lost = self.parts.controller.homing_required();
        let latch = self.parts.latch.as_ref().filter(|latch| tracking_lost && latch.homing_required().is_none());
        if let Some(Err(error)) = latch.map(|latch| latch.require_homing("reset before the axes were seen to stand")) {
            self.log_event(now_s, "", format!("that the position is lost could not be written down: {error}"));
        }
    }

    /// The axes have been homed.
    fn clear_homing_required(&mut self, now_s: f64) {
        if let Some(Err(error)) = self.parts.latch.as_ref().map(Latch::clear_homing_required) {
            self.log_event(now_s, "", format!("that the axes are homed could not be written down: {error}"));
        }
    }

    /// Moves the tendons to `pulls_m` in about `duration_s`, if the limits and the state of the robot let them.
    ///
    /// # Errors
    /// [`MoveError`]: nothing has left.
    pub fn command(&mut self, pulls_m: &[f64], duration_s: f64, now_s: f64) -> Result<(), MoveError> {
        self.check_command(pulls_m, duration_s)?;
        let target: [f64; AXES] = std::array::from_fn(|axis| pulls_m[axis]);
        self.send_move(target, duration_s, now_s)
    }

    /// Whether [`Rig::command`] would carry it out.
    ///
    /// # Errors
    /// [`MoveError`].
    pub fn check_command(&self, pulls_m: &[f64], duration_s: f64) -> Result<(), MoveError> {
        if *self.state() != GuardState::Active {
            return Err(MoveError::NotActive(self.state().name()));
        }
        Ok(self.parts.limits.check_command(pulls_m, &self.commanded_m, duration_s, 1)?)
    }

    /// Moves all tendons towards home by no more than one command may; true once they are there. From the switches the
    /// way home is longer than any displacement that a policy may ask for, so the limit of travel does not apply to it.
    ///
    /// # Errors
    /// [`MoveError`]: nothing has left.
    pub fn step_towards_home(&mut self, duration_s: f64, now_s: f64) -> Result<bool, MoveError> {
        if *self.state() != GuardState::Active {
            return Err(MoveError::NotActive(self.state().name()));
        }
        let limits = &self.parts.limits;
        let step_m = limits.step_m(duration_s);
        let largest_m = self.commanded_m.iter().fold(0.0_f64, |largest, pull| largest.max(pull.abs()));
        let share = if largest_m > step_m { 1.0 - step_m / largest_m } else { 0.0 };
        self.send_move(self.commanded_m.map(|pull| pull * share), duration_s, now_s)?;
        Ok(share == 0.0)
    }

    fn send_move(&mut self, pulls_m: [f64; AXES], duration_s: f64, now_s: f64) -> Result<(), MoveError> {
        let (from_mm, to_mm) = (self.parts.machine_mm(&self.commanded_m), self.parts.machine_mm(&pulls_m));
        let length_mm = from_mm.iter().zip(&to_mm).map(|(from, to)| (to - from).powi(2)).sum::<f64>().sqrt();
        if length_mm >= MIN_MOVE_MM {
            let feed_mm_min = (length_mm / (MOVING_SHARE * duration_s) * 60.0).max(MIN_FEED_MM_MIN);
            match self.parts.controller.move_to(to_mm, feed_mm_min, now_s) {
                Ok(()) => {}
                // A controller that was held says so until its next report.
                Err(MotionFault::Busy | MotionFault::Refused(grbl::MoveRefusal::NotReady(_))) => {
                    return Err(MoveError::Busy);
                }
                Err(MotionFault::Refused(refusal)) => return Err(MoveError::RefusedByDriver(refusal)),
                // The next poll finds the same fault and acts on it.
                Err(_) => return Err(MoveError::NotActive("without motors")),
            }
        }
        self.commanded_m = pulls_m;
        Ok(())
    }

    /// The robot does not do what it was told in the time that it has: it is stopped, for whoever comes next as well.
    pub fn stop(&mut self, what: String, now_s: f64) {
        let action = self.guard.request_stop(StopReason { kind: "controller", what, remedy: ARM.to_owned() }, now_s);
        self.apply_action(action, now_s);
        if action != SafetyAction::Nothing {
            self.log_state(now_s);
        }
    }

    /// The program ends: a robot that moves is held, and what is queued is forgotten at one of the next polls, as after a
    /// stop, so that the next program finds it standing. False when there is nothing left to wait for.
    pub fn shut_down(&mut self, why: &str, now_s: f64) -> bool {
        if !self.stands() || *self.state() == GuardState::Homing {
            let action = self.guard.request_stop(program_ended(why), now_s);
            self.apply_action(action, now_s);
            if action != SafetyAction::Nothing {
                self.log_state(now_s);
            }
        }
        self.guard.is_stopping()
    }

    /// The pose at `time_s`, between the frames around it, if the guard would believe it.
    pub fn tip_at(&self, time_s: f64) -> Option<TipPose> {
        self.parts.tracking.pose_at(time_s).filter(|pose| self.is_plausible(pose))
    }

    fn is_plausible(&self, pose: &TipPose) -> bool {
        let near = |expected_m: &Point3| distance_m(&pose.position_m, expected_m) <= self.parts.limits.tip_from_model_m;
        self.expected_m.as_ref().is_none_or(near)
    }

    /// The last pose, if it was fresh enough at `time_s` not to hold the robot.
    pub fn fresh_tip(&self, time_s: f64) -> Option<TipPose> {
        let fresh = |pose: &&TipPose| time_s - pose.time_s <= self.parts.limits.tracking_hold_s;
        self.parts.tracking.latest().filter(fresh).filter(|pose| self.is_plausible(pose)).cloned()
    }

    /// Logs the state that has been reached.
    fn log_state(&mut self, now_s: f64) {
        let (kind, what) = match self.state() {
            GuardState::Held { reason, .. } => (reason.kind, format!("{}; goes on by itself", reason.what)),
            GuardState::Stopped { reason, .. } => {
                let reason = reason.clone();
                let mut what = format!("{}; {}", reason.what, reason.remedy);
                let latch = self.parts.latch.as_ref().filter(|_| ![INTERRUPTED, ENDED].contains(&reason.kind));
                if let Some(Err(error)) = latch.map(|latch| latch.stop(&reason)) {
                    what = format!("{what}; this stop could not be written down for the next program: {error}");
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
            // The log is for people; the robot does not depend on it.
            let _ = latch.write(&format!("{time_s:10.3} s  {state:8} {kind:12} {what}"));
        }
        self.events.push(Event { time_s, state, kind, what });
    }
}
