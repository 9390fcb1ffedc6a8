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
const MOST_QUEUED: usize = 2;

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
    pub(super) asked_s: Option<f64>,
    pub(super) next_ask_s: f64,
    pub(super) homing: HomingPhase,
    /// When a reset was sent whose greeting has not come.
    pub(super) reset_s: Option<f64>,
    /// Until then a greeting may still be due to a reset: the controller may have reset itself just before.
    pub(super) greetings_until_s: f64,
    pub(super) held: bool,
    /// When moves that were held were last told to go on, s; its reports may lag behind.
    pub(super) resumed_s: f64,
    pub(super) set_up: bool,
    /// What the controller says; it leaves this out of most reports.
    pub(super) says_homed: bool,
    /// Whatever it says, something has happened since.
    pub(super) must_home: bool,
    pub(super) garbled_s: VecDeque<f64>,
    pub(super) path: CommandedPath,
    pub(super) stillness: StallDetector,
}

impl Controller {
    /// Wakes the controller and checks that it is the right one with the right settings; moves nothing. Waits on
    /// `clock`, some seconds at most.
    ///
    /// # Errors
    /// [`MotionFault`] names what was found and what is expected.
    pub fn open(
        wire: Box<dyn SerialLine>,
        settings: &MotionSettings,
        clock: &dyn Clock,
    ) -> Result<Controller, MotionFault> {
        settings.check()?;
        let mut port = Port::new(wire);
        let (machine, status) = handshake::introduce(&mut port, settings, clock)?;
        let now_s = clock.now_s();
        let mut controller = Controller {
            port,
            settings: settings.clone(),
            machine,
            state: ControllerState { last_reply_s: now_s, ..ControllerState::default() },
            fault: None,
            pending: None,
            asked_s: None,
            next_ask_s: now_s,
            homing: HomingPhase::No,
            reset_s: None,
            greetings_until_s: now_s,
            held: false,
            resumed_s: f64::NEG_INFINITY,
            set_up: false,
            says_homed: false,
            must_home: false,
            garbled_s: VecDeque::new(),
            path: CommandedPath::default(),
            stillness: StallDetector::default(),
        };
        // Nothing moves: all blocks that there are are free, whatever the controller said that it has.
        if let (Mode::Idle, Some(free)) = (status.mode, status.free_blocks) {
            controller.machine.blocks = free;
        }
        controller.reported(&status, now_s);
        controller.fault.clone().map_or(Ok(controller), Err)
    }

    /// Reads what has arrived, notices what is wrong, and asks for the state ten times a second.
    ///
    /// # Errors
    /// The first fault since the controller was opened or reset, at every call.
    pub fn poll(&mut self, now_s: f64) -> Result<(), MotionFault> {
        self.read(now_s);
        self.check_deadlines(now_s);
        self.go_on(now_s);
        self.fault.clone().map_or(Ok(()), Err)
    }

    /// Sends the axes to their switches, as soon as the controller takes it. What goes wrong shows in
    /// [`Controller::poll`].
    pub fn start_homing(&mut self, now_s: f64) {
        if self.fault.is_none() && self.homing == HomingPhase::No {
            self.homing = HomingPhase::Wanted;
            self.home_if_free(now_s);
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
    pub fn distrust(&mut self) {
        self.must_home = true;
        self.path.forget();
        self.note_homed();
    }

    /// True while the count of steps is not believed whatever the controller says.
    pub fn is_distrusted(&self) -> bool {
        self.must_home
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
    pub fn faced_mm(&self, along_mm: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|axis| self.settings.facing(axis) * along_mm[axis])
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
        let ready = matches!(self.state.mode, Mode::Idle | Mode::Run) && !self.held && self.reset_s.is_none();
        if !ready || self.is_homing() {
            return Err(MoveRefusal::NotReady(self.state.mode).into());
        }
        let room = self.pending.is_none() && self.state.queued < MOST_QUEUED;
        if !(room && self.set_up && self.path.is_known()) {
            return Err(MotionFault::Busy);
        }
        self.path.push(the_move.target_mm);
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
            self.stillness.begin_again(now_s);
            self.send_byte(RESUME);
        }
    }

    /// Stops the controller and drops its moves. Standing axes keep their position; moving ones have to be homed again,
    /// and so do all after a fault.
    pub fn reset(&mut self, now_s: f64) {
        if !self.stands() || self.fault.is_some() || self.is_homing() {
            self.must_home = true;
        }
        if !matches!(self.fault, Some(MotionFault::Unplugged { .. })) {
            self.fault = None;
        }
        self.start_over();
        self.held = false;
        self.reset_s = Some(now_s);
        self.greetings_until_s = now_s + self.settings.reply_timeout_s + GREETING_S;
        self.garbled_s.clear();
        self.send_byte(RESET);
    }

    /// Nothing is known of a controller that has just started.
    pub(super) fn start_over(&mut self) {
        self.pending = None;
        self.asked_s = None;
        self.homing = HomingPhase::No;
        self.set_up = false;
        self.path.forget();
        self.state.mode = Mode::Unknown;
        self.state.unacknowledged = 0;
        self.state.queued = 0;
        self.state.feed_mm_min = 0.0;
        self.note_homed();
    }

    pub(super) fn note_homed(&mut self) {
        self.state.homed = self.says_homed && !self.must_home;
    }

    /// Records a fault; the first one stays.
    pub(super) fn fail(&mut self, fault: MotionFault) {
        self.fault.get_or_insert(fault);
        self.must_home = true;
        self.homing = HomingPhase::No;
        self.pending = None;
        self.asked_s = None;
        self.state.unacknowledged = 0;
        self.path.forget();
        self.note_homed();
    }
}
