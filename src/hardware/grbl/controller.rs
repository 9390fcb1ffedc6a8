//! The controller's driver: a state machine that never blocks.

use std::collections::VecDeque;

use super::fault::{MotionFault, MoveRefusal};
use super::gcode;
use super::gcode::{HOLD, RESET};
use super::handshake;
use super::handshake::ControllerInfo;
use super::motion_monitor::{CommandedPath, StallDetector};
use super::pending::{HomingPhase, LinePurpose, PendingLine};
use super::port::Port;
use super::resumption::Resumption;
use super::settings::{GREETING_S, MotionSettings};
use super::state::{ControllerState, HOMING_REQUIRED, Mode};
use crate::hardware::clock::Clock;
use crate::hardware::serial::SerialLine;

/// Most moves in the controller's queue.
const MAX_QUEUED: usize = 2;

/// Driver of a GRBL controller with four axes. No call blocks except [`Controller::open`].
///
/// After a fault it accepts no move until [`Controller::reset`] and homing; hold and reset always
/// work.
pub struct Controller {
    pub(super) port: Port,
    pub(super) settings: MotionSettings,
    pub(super) info: ControllerInfo,
    pub(super) state: ControllerState,
    pub(super) fault: Option<MotionFault>,
    pub(super) pending: Option<PendingLine>,
    /// When the first unanswered status query was sent.
    pub(super) query_sent_s: Option<f64>,
    /// When the last one was sent: one may be lost, and is asked again.
    pub(super) last_query_s: f64,
    /// When the queries were sent that may still be answered, s.
    pub(super) query_times_s: VecDeque<f64>,
    /// When the query was sent that the last report answers, at the earliest, s.
    pub(super) answered_query_s: f64,
    pub(super) next_query_s: f64,
    pub(super) homing: HomingPhase,
    /// When a reset was sent whose greeting has not arrived.
    pub(super) reset_sent_s: Option<f64>,
    /// Until then a greeting may still belong to a reset: the controller may have reset itself just
    /// before.
    pub(super) greeting_expected_until_s: f64,
    pub(super) holding: bool,
    pub(super) resumption: Resumption,
    /// Target, mm, and feed, mm/min, of the last move.
    pub(super) last_move: Option<([f64; 4], f64)>,
    /// When held moves were last resumed, s; status reports may lag behind.
    pub(super) resumed_s: f64,
    /// Since when the controller is in a hold that this program did not request, s.
    pub(super) foreign_hold_s: Option<f64>,
    pub(super) setup_acknowledged: bool,
    /// Whether the controller reports itself as homed; most reports leave this out.
    pub(super) reported_homed: bool,
    /// Homing is required regardless of what the controller reports.
    pub(super) homing_required: bool,
    pub(super) garbled_times_s: VecDeque<f64>,
    /// The last unreadable line, with its time.
    pub(super) last_garbled: Option<(f64, String)>,
    pub(super) commanded_path: CommandedPath,
    pub(super) stall_detector: StallDetector,
}

impl Controller {
    /// Wakes the controller and checks firmware and settings; moves nothing. Waits on `clock` for a
    /// few seconds at most.
    ///
    /// # Errors
    /// [`MotionFault`] says what was found and what was expected.
    pub fn open(
        serial: Box<dyn SerialLine>,
        settings: &MotionSettings,
        clock: &dyn Clock,
    ) -> Result<Controller, MotionFault> {
        settings.check()?;
        let mut port = Port::new(serial);
        let (info, status) = handshake::identify_controller(&mut port, settings, clock)?;
        let now_s = clock.now_s();
        let mut controller = Controller {
            port,
            settings: settings.clone(),
            info,
            state: ControllerState { last_reply_s: now_s, ..ControllerState::default() },
            fault: None,
            pending: None,
            query_sent_s: None,
            last_query_s: now_s,
            query_times_s: VecDeque::new(),
            answered_query_s: f64::NEG_INFINITY,
            next_query_s: now_s,
            homing: HomingPhase::No,
            reset_sent_s: None,
            greeting_expected_until_s: now_s,
            holding: false,
            resumption: Resumption::default(),
            last_move: None,
            resumed_s: f64::NEG_INFINITY,
            foreign_hold_s: None,
            setup_acknowledged: false,
            reported_homed: false,
            homing_required: false,
            garbled_times_s: VecDeque::new(),
            last_garbled: None,
            commanded_path: CommandedPath::default(),
            stall_detector: StallDetector::default(),
        };
        // At rest all blocks are free: this is the true queue length, whatever the controller
        // reported.
        if let (Mode::Idle, Some(free)) = (status.mode, status.free_blocks) {
            controller.info.blocks = free;
        }
        controller.apply_status(&status, now_s);
        // A controller in a wrong mode must not be handed out.
        controller.fault.clone().map_or(Ok(controller), Err)
    }

    /// Reads what has arrived, checks it, and queries the status twenty times a second.
    ///
    /// # Errors
    /// The first fault since the controller was opened or reset; returned by every call until the
    /// next reset.
    pub fn poll(&mut self, now_s: f64) -> Result<(), MotionFault> {
        // Read before checking deadlines: an answer that has arrived is not late.
        self.read_replies(now_s);
        self.check_deadlines(now_s);
        self.continue_resume(now_s);
        self.send_due(now_s);
        self.fault.clone().map_or(Ok(()), Err)
    }

    /// Starts homing as soon as the controller accepts it. A controller that was in alarm already
    /// is reset first: it stands, and its position is discarded by homing. Failures are reported by
    /// [`Controller::poll`].
    pub fn start_homing(&mut self, now_s: f64) {
        if self.fault.is_none() && self.homing == HomingPhase::No {
            if self.alarm().is_some() {
                self.reset(now_s);
            }
            self.homing = HomingPhase::Wanted;
            self.start_homing_if_free(now_s);
        }
    }

    /// True from [`Controller::start_homing`] until the axes are homed or a fault ends homing.
    pub fn is_homing(&self) -> bool {
        self.homing != HomingPhase::No
    }

    /// The alarm that locks the controller at rest, 0 if its number is unknown; none if it is
    /// locked only because it is not homed.
    pub fn alarm(&self) -> Option<u16> {
        match self.state.mode {
            Mode::Alarm(code) => Some(code.unwrap_or(0)).filter(|&code| code != HOMING_REQUIRED),
            _ => None,
        }
    }

    /// True when positions count from the homing switches.
    pub fn homed(&self) -> bool {
        self.state.homed
    }

    /// Discards the position: it is not trusted until the axes have been homed again, whatever the
    /// controller reports.
    pub fn require_homing(&mut self) {
        self.homing_required = true;
        self.commanded_path.discard();
        self.update_homed();
    }

    /// True while the position is not trusted, whatever the controller reports.
    pub fn homing_required(&self) -> bool {
        self.homing_required
    }

    /// True when nothing moves and no move is pending, because the queue is empty or a hold is
    /// complete. A reset now keeps the position.
    pub fn stands(&self) -> bool {
        let done =
            self.state.mode == Mode::Idle && self.pending.is_none() && self.state.queued == 0;
        done || self.state.mode == Mode::Hold { complete: true }
    }

    /// What is known about the controller.
    pub fn state(&self) -> &ControllerState {
        &self.state
    }

    /// Converts between distances from the switches and machine positions, mm. The conversion is
    /// its own inverse.
    pub fn mirrored_mm(&self, along_mm: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|axis| self.settings.axis_sign(axis) * along_mm[axis])
    }

    /// What the controller said about itself when it was opened.
    pub fn info(&self) -> &ControllerInfo {
        &self.info
    }

    /// The fault that blocks motion.
    pub fn fault(&self) -> Option<&MotionFault> {
        self.fault.as_ref()
    }

    /// Moves all axes in a straight line to `target_mm` (machine positions of X, Y, Z and A) at
    /// `feed_mm_min`, measured along the path in all four axes.
    ///
    /// # Errors
    /// [`MotionFault::Busy`] or [`MotionFault::Refused`] leave the driver usable; any other fault
    /// was found before. Nothing was sent.
    pub fn move_to(
        &mut self,
        target_mm: [f64; 4],
        feed_mm_min: f64,
        now_s: f64,
    ) -> Result<(), MotionFault> {
        if let Some(fault) = &self.fault {
            return Err(fault.clone());
        }
        // Limits first: a wrong target is refused for what it is, whatever the state.
        let the_move = gcode::compose(target_mm, feed_mm_min, &self.settings)?;
        if !self.state.homed {
            return Err(MoveRefusal::NotHomed.into());
        }
        let ready = matches!(self.state.mode, Mode::Idle | Mode::Run)
            && !self.holding
            && self.reset_sent_s.is_none();
        if !ready || self.is_homing() {
            return Err(MoveRefusal::NotReady(self.state.mode).into());
        }
        let has_room = self.pending.is_none() && self.state.queued < MAX_QUEUED;
        if !(has_room && self.setup_acknowledged && self.commanded_path.is_known()) {
            return Err(MotionFault::Busy);
        }
        // Before sending: a report may follow at once and is checked against it.
        self.commanded_path.push(the_move.target_mm);
        self.last_move = Some((the_move.target_mm, feed_mm_min));
        self.state.moves += 1;
        self.send(the_move.line, LinePurpose::Move, now_s);
        self.fault.clone().map_or(Ok(()), Err)
    }

    /// Decelerates all axes to a standstill, which keeps the position. Queued moves wait.
    pub fn hold(&mut self, now_s: f64) {
        self.holding = true;
        self.pending.iter_mut().for_each(|pending| pending.hold(now_s));
        self.resumption.hold(now_s);
        if matches!(self.state.mode, Mode::Hold { .. }) {
            // The axes may have moved again since the last report.
            self.state.mode = Mode::Hold { complete: false };
        }
        self.send_byte(HOLD);
    }

    /// Resets the controller and discards its moves. Axes at rest keep their position. Moving axes
    /// must be homed again, and so must all axes after a fault.
    pub fn reset(&mut self, now_s: f64) {
        // A reset of moving axes loses steps.
        if !self.stands() || self.fault.is_some() || self.is_homing() {
            self.homing_required = true;
        }
        // No reset reaches a line that is gone.
        if !matches!(self.fault, Some(MotionFault::Unplugged { .. })) {
            self.fault = None;
        }
        self.clear_motion_state();
        self.holding = false;
        self.resumption = Resumption::default();
        self.reset_sent_s = Some(now_s);
        self.greeting_expected_until_s = now_s + self.settings.reply_timeout_s + GREETING_S;
        self.garbled_times_s.clear();
        self.send_byte(RESET);
    }

    /// Forgets what was known about motion: the controller has just started.
    pub(super) fn clear_motion_state(&mut self) {
        self.pending = None;
        self.query_sent_s = None;
        self.homing = HomingPhase::No;
        self.foreign_hold_s = None;
        self.setup_acknowledged = false;
        self.commanded_path.discard();
        self.last_move = None;
        self.state.mode = Mode::Unknown;
        self.state.unacknowledged = 0;
        self.state.queued = 0;
        self.state.feed_mm_min = 0.0;
        self.update_homed();
    }

    pub(super) fn update_homed(&mut self) {
        self.state.homed = self.reported_homed && !self.homing_required;
    }

    /// Records a fault; the first one is kept.
    pub(super) fn record_fault(&mut self, fault: MotionFault) {
        // Later faults are mostly consequences of the first.
        self.fault.get_or_insert(fault);
        self.homing_required = true;
        self.homing = HomingPhase::No;
        self.pending = None;
        self.query_sent_s = None;
        self.state.unacknowledged = 0;
        self.commanded_path.discard();
        self.update_homed();
    }
}
