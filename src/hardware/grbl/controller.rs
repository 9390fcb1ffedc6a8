//! The controller's driver: a state machine that never waits.

use std::collections::VecDeque;

use super::fault::{MotionFault, MoveRefusal};
use super::gcode;
use super::gcode::{HOLD, RESET, RESUME};
use super::handshake;
use super::handshake::ControllerInfo;
use super::motion_monitor::{CommandedPath, StallDetector};
use super::pending::{HomingPhase, LinePurpose, PendingLine};
use super::port::Port;
use super::settings::{GREETING_S, MotionSettings};
use super::state::{ControllerState, Mode};
use crate::hardware::clock::Clock;
use crate::hardware::serial::SerialLine;

/// Moves that the controller may have in its queue.
const MAX_QUEUED: usize = 2;

/// A GRBL controller with four axes. Nothing here waits except [`Controller::open`].
///
/// After a fault it takes no move before [`Controller::reset`] and homing; holding and resetting always work.
pub struct Controller {
    pub(super) port: Port,
    pub(super) settings: MotionSettings,
    pub(super) machine: ControllerInfo,
    pub(super) state: ControllerState,
    pub(super) fault: Option<MotionFault>,
    pub(super) pending: Option<PendingLine>,
    /// When the status query left that has not been answered.
    pub(super) query_sent_s: Option<f64>,
    pub(super) next_query_s: f64,
    pub(super) homing: HomingPhase,
    /// When a reset was sent whose greeting has not come.
    pub(super) reset_sent_s: Option<f64>,
    /// Until then a greeting may still be due to a reset: the controller may have reset itself just before.
    pub(super) greeting_expected_until_s: f64,
    pub(super) held: bool,
    /// When moves that were held were last told to go on, s; its reports may lag behind.
    pub(super) resumed_s: f64,
    pub(super) setup_acknowledged: bool,
    /// What the controller says; it leaves this out of most reports.
    pub(super) reported_homed: bool,
    /// Whatever it says, something has happened since.
    pub(super) homing_required: bool,
    pub(super) garbled_s: VecDeque<f64>,
    pub(super) commanded_path: CommandedPath,
    pub(super) stall_detector: StallDetector,
}

impl Controller {
    /// Wakes the controller and checks that it is the right one with the right settings; moves nothing. Waits on
    /// `clock`, some seconds at most.
    ///
    /// # Errors
    /// [`MotionFault`] names what was found and what is expected.
    pub fn open(
        serial: Box<dyn SerialLine>,
        settings: &MotionSettings,
        clock: &dyn Clock,
    ) -> Result<Controller, MotionFault> {
        settings.check()?;
        let mut port = Port::new(serial);
        let (machine, status) = handshake::identify_controller(&mut port, settings, clock)?;
        let now_s = clock.now_s();
        let mut controller = Controller {
            port,
            settings: settings.clone(),
            machine,
            state: ControllerState { last_reply_s: now_s, ..ControllerState::default() },
            fault: None,
            pending: None,
            query_sent_s: None,
            next_query_s: now_s,
            homing: HomingPhase::No,
            reset_sent_s: None,
            greeting_expected_until_s: now_s,
            held: false,
            resumed_s: f64::NEG_INFINITY,
            setup_acknowledged: false,
            reported_homed: false,
            homing_required: false,
            garbled_s: VecDeque::new(),
            commanded_path: CommandedPath::default(),
            stall_detector: StallDetector::default(),
        };
        // Nothing moves: all blocks that there are are free, whatever the controller said that it has.
        if let (Mode::Idle, Some(free)) = (status.mode, status.free_blocks) {
            controller.machine.blocks = free;
        }
        controller.apply_status(&status, now_s);
        controller.fault.clone().map_or(Ok(controller), Err)
    }

    /// Reads what has arrived, notices what is wrong, and asks for the state ten times a second.
    ///
    /// # Errors
    /// The first fault since the controller was opened or reset, at every call.
    pub fn poll(&mut self, now_s: f64) -> Result<(), MotionFault> {
        self.read_replies(now_s);
        self.check_deadlines(now_s);
        self.send_due(now_s);
        self.fault.clone().map_or(Ok(()), Err)
    }

    /// Sends the axes to their switches, as soon as the controller takes it. What goes wrong shows in
    /// [`Controller::poll`].
    pub fn start_homing(&mut self, now_s: f64) {
        if self.fault.is_none() && self.homing == HomingPhase::No {
            self.homing = HomingPhase::Wanted;
            self.start_homing_if_free(now_s);
        }
    }

    /// True from [`Controller::start_homing`] until the axes stand at home or a fault ends it.
    pub fn is_homing(&self) -> bool {
        self.homing != HomingPhase::No
    }

    /// True when positions count from the switches.
    pub fn homed(&self) -> bool {
        self.state.homed
    }

    /// Whatever the controller says, its count of steps is not believed before it has been homed again.
    pub fn require_homing(&mut self) {
        self.homing_required = true;
        self.commanded_path.forget();
        self.update_homed();
    }

    /// True while the count of steps is not believed whatever the controller says.
    pub fn homing_required(&self) -> bool {
        self.homing_required
    }

    /// True when nothing moves and nothing is about to, be it because everything has been done or because a hold has come to
    /// its end: a reset now keeps the position.
    pub fn stands(&self) -> bool {
        let done = self.state.mode == Mode::Idle && self.pending.is_none() && self.state.queued == 0;
        done || self.state.mode == Mode::Hold { complete: true }
    }

    /// What is known of the controller.
    pub fn state(&self) -> &ControllerState {
        &self.state
    }

    /// Machine positions for distances from the switches and the other way round, mm.
    pub fn mirrored_mm(&self, along_mm: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|axis| self.settings.axis_sign(axis) * along_mm[axis])
    }

    /// What the controller said about itself when it was opened.
    pub fn machine(&self) -> &ControllerInfo {
        &self.machine
    }

    /// The fault that keeps the controller from moving.
    pub fn fault(&self) -> Option<&MotionFault> {
        self.fault.as_ref()
    }

    /// Moves all axes in a straight line to `target_mm` (machine positions of X, Y, Z and A) at `feed_mm_min` along
    /// the path in all four.
    ///
    /// # Errors
    /// [`MotionFault::Busy`] or [`MotionFault::Refused`], after which it goes on as before; any other is a fault that
    /// has been found before. Nothing was sent.
    pub fn move_to(&mut self, target_mm: [f64; 4], feed_mm_min: f64, now_s: f64) -> Result<(), MotionFault> {
        if let Some(fault) = &self.fault {
            return Err(fault.clone());
        }
        let the_move = gcode::compose(target_mm, feed_mm_min, &self.settings)?;
        if !self.state.homed {
            return Err(MoveRefusal::NotHomed.into());
        }
        let ready = matches!(self.state.mode, Mode::Idle | Mode::Run) && !self.held && self.reset_sent_s.is_none();
        if !ready || self.is_homing() {
            return Err(MoveRefusal::NotReady(self.state.mode).into());
        }
        let room = self.pending.is_none() && self.state.queued < MAX_QUEUED;
        if !(room && self.setup_acknowledged && self.commanded_path.is_known()) {
            return Err(MotionFault::Busy);
        }
        self.commanded_path.push(the_move.target_mm);
        self.state.moves += 1;
        self.send(the_move.line, LinePurpose::Move, now_s);
        self.fault.clone().map_or(Ok(()), Err)
    }

    /// Slows all axes down to a stand, which keeps the position. The rest of the moves waits.
    pub fn hold(&mut self, _now_s: f64) {
        self.held = true;
        if matches!(self.state.mode, Mode::Hold { .. }) {
            // It may have begun to move since it said so.
            self.state.mode = Mode::Hold { complete: false };
        }
        self.send_byte(HOLD);
    }

    /// Goes on with the moves that were held, unless there is a fault.
    pub fn resume(&mut self, now_s: f64) {
        if self.fault.is_none() {
            self.held = false;
            self.resumed_s = now_s;
            self.stall_detector.restart(now_s);
            self.send_byte(RESUME);
        }
    }

    /// Stops the controller and drops its moves. Standing axes keep their position; moving ones have to be homed again,
    /// and so do all after a fault.
    pub fn reset(&mut self, now_s: f64) {
        if !self.stands() || self.fault.is_some() || self.is_homing() {
            self.homing_required = true;
        }
        if !matches!(self.fault, Some(MotionFault::Unplugged { .. })) {
            self.fault = None;
        }
        self.clear_motion_state();
        self.held = false;
        self.reset_sent_s = Some(now_s);
        self.greeting_expected_until_s = now_s + self.settings.reply_timeout_s + GREETING_S;
        self.garbled_s.clear();
        self.send_byte(RESET);
    }

    /// Nothing is known of a controller that has just started.
    pub(super) fn clear_motion_state(&mut self) {
        self.pending = None;
        self.query_sent_s = None;
        self.homing = HomingPhase::No;
        self.setup_acknowledged = false;
        self.commanded_path.forget();
        self.state.mode = Mode::Unknown;
        self.state.unacknowledged = 0;
        self.state.queued = 0;
        self.state.feed_mm_min = 0.0;
        self.update_homed();
    }

    pub(super) fn update_homed(&mut self) {
        self.state.homed = self.reported_homed && !self.homing_required;
    }

    /// Records a fault; the first one stays.
    pub(super) fn record_fault(&mut self, fault: MotionFault) {
        self.fault.get_or_insert(fault);
        self.homing_required = true;
        self.homing = HomingPhase::No;
        self.pending = None;
        self.query_sent_s = None;
        self.state.unacknowledged = 0;
        self.commanded_path.forget();
        self.update_homed();
    }
}
