//! State changes on each reply of the controller.

use super::controller::Controller;
use super::fault::MotionFault;
use super::motion_monitor;
use super::parser::{ReceivedLine, Reply, StatusReport, parse};
use super::pending::{HomingPhase, LinePurpose, PendingLine};
use super::state::{HOMING_REQUIRED, Mode};

/// Unreadable lines within [`GARBLED_S`] that cause a fault.
const MAX_GARBLED: usize = 3;
/// See [`MAX_GARBLED`], seconds.
const GARBLED_S: f64 = 10.0;
/// Shortest time without motion, s, after which pending moves count as stalled; the reply timeout
/// applies if it is longer. Reports come every 50 ms, and the slowest move turns a screw by a step
/// in less than 0.15 s.
const MIN_STALL_S: f64 = 0.3;
/// Time for which a hold that this program did not request may precede an alarm, s: grblHAL stops
/// the axes before it reports a target outside the travel.
const HOLD_BEFORE_ALARM_S: f64 = 0.3;

impl Controller {
    /// Processes everything that has arrived.
    pub(super) fn read_replies(&mut self, now_s: f64) {
        let (received_lines, gone) = self.port.read();
        for received in received_lines {
            self.state.last_reply_s = now_s;
            match received {
                ReceivedLine::Line(line) => match parse(&line) {
                    Some(reply) => self.apply_reply(reply, now_s),
                    None => self.apply_garbled(line, now_s),
                },
                ReceivedLine::Garbled(line) => self.apply_garbled(line, now_s),
            }
        }
        if let Err(error) = gone {
            // It replaces any other fault, since a reset cannot clear it.
            self.fault = Some(MotionFault::unplugged(&error));
            self.record_fault(MotionFault::unplugged(&error));
        }
    }

    fn apply_reply(&mut self, reply: Reply, now_s: f64) {
        match reply {
            Reply::Ok => self.apply_ok(),
            Reply::Error(code) => self.apply_error(code),
            Reply::Alarm(code) => self.apply_alarm(code),
            Reply::Boot(greeting) => self.apply_greeting(greeting, now_s),
            Reply::Status(status) => self.apply_status(&status, now_s),
            Reply::Info { name, text } if name == "MSG" && !text.is_empty() => {
                self.state.message = text
            }
            Reply::Info { .. } | Reply::Setting { .. } | Reply::StartupBlock(_) => {}
        }
    }

    fn apply_garbled(&mut self, line: String, now_s: f64) {
        self.state.garbled += 1;
        self.last_garbled = Some((now_s, line.clone()));
        // The unreadable line may have been the awaited report: query again.
        self.query_sent_s = None;
        self.garbled_times_s.retain(|&then_s| now_s - then_s <= GARBLED_S);
        self.garbled_times_s.push_back(now_s);
        let count = self.garbled_times_s.len();
        if count >= MAX_GARBLED {
            self.garbled_times_s.clear();
            self.record_fault(MotionFault::Garbled { count, line });
        }
    }

    fn take_pending(&mut self) -> Option<PendingLine> {
        self.state.unacknowledged = 0;
        self.pending.take()
    }

    fn apply_ok(&mut self) {
        // Lines sent before a reset or a fault may still be acknowledged.
        if self.reset_sent_s.is_some() || self.fault.is_some() {
            return;
        }
        match self.take_pending().map(|pending| pending.purpose) {
            // Until a report says otherwise: the queue is never underestimated.
            Some(LinePurpose::Move) => self.state.queued += 1,
            Some(LinePurpose::Setup) => self.setup_acknowledged = true,
            Some(LinePurpose::Homing) => {
                self.homing = HomingPhase::Settling;
                self.reported_homed = true;
                self.homing_required = false;
                self.setup_acknowledged = false;
                self.state.queued = 0;
                self.update_homed();
            }
            None => self.record_fault(MotionFault::StrayOk),
        }
    }

    fn apply_error(&mut self, code: u16) {
        if self.reset_sent_s.is_some() {
            return;
        }
        let line =
            self.take_pending().map_or_else(|| "(nothing)".to_owned(), |pending| pending.line);
        self.record_fault(MotionFault::Error { code, line });
    }

    fn apply_alarm(&mut self, code: u16) {
        let expected = match self.state.mode {
            _ if self.reset_sent_s.is_some() => true,
            Mode::Unknown => true,
            Mode::Alarm(present) => present == Some(code) || code == HOMING_REQUIRED,
            _ => false,
        };
        self.state.mode = Mode::Alarm(Some(code));
        self.homing_required = true;
        self.commanded_path.discard();
        self.update_homed();
        if !expected {
            self.record_fault(MotionFault::Alarm { code });
        }
    }

    fn apply_greeting(&mut self, greeting: String, now_s: f64) {
        let awaited = self.reset_sent_s.take().is_some();
        let expected =
            awaited || (self.pending.is_none() && now_s <= self.greeting_expected_until_s);
        // A second greeting may come from a controller that lost power.
        self.homing_required |= !awaited;
        let homing = self.homing;
        self.clear_motion_state();
        if expected && homing == HomingPhase::Wanted {
            self.homing = homing;
        }
        self.next_query_s = now_s;
        if !expected {
            self.record_fault(MotionFault::Rebooted { greeting });
        }
    }

    pub(super) fn apply_status(&mut self, status: &StatusReport, now_s: f64) {
        let status = &self.with_alarm_number(&self.with_hold_completed(status));
        self.query_sent_s = None;
        // The oldest query: a report is at least as new as that.
        self.answered_query_s = self.query_times_s.pop_front().unwrap_or(f64::NEG_INFINITY);
        self.state.last_status_s = now_s;
        self.state.pins = status.pins;
        let before = std::mem::replace(&mut self.state.mode, status.mode);
        self.state.position_mm = status.position_mm.unwrap_or(self.state.position_mm);
        self.state.feed_mm_min = status.feed_mm_min.unwrap_or(self.state.feed_mm_min);
        if self.homing == HomingPhase::Running {
            // The alarm's own line may have been unreadable; an alarm from before homing may still
            // be in transit.
            let has_begun = self
                .pending
                .as_ref()
                .is_some_and(|homing| now_s - homing.sent_s > self.settings.reply_timeout_s);
            if let Mode::Alarm(Some(code)) = status.mode
                && code != HOMING_REQUIRED
                && has_begun
            {
                return self.record_fault(MotionFault::Alarm { code });
            }
            self.state.mode = Mode::Home;
            return;
        }
        self.count_blocks(status, before);
        if self.reset_sent_s.is_some() {
            return;
        }
        if let Err(fault) =
            self.check_mode(status, before, now_s).and_then(|()| self.check_position(status, now_s))
        {
            self.record_fault(fault);
        }
    }

    /// A hold without a sub-state is complete when two reports give the same position.
    fn with_hold_completed(&self, status: &StatusReport) -> StatusReport {
        let stands = status.position_mm == Some(self.state.position_mm);
        let was_holding = matches!(self.state.mode, Mode::Hold { .. });
        let mode = if status.bare_hold && was_holding {
            Mode::Hold { complete: stands }
        } else {
            status.mode
        };
        StatusReport { mode, ..*status }
    }

    /// Some reports name no alarm: its number was pushed when it was raised.
    fn with_alarm_number(&self, status: &StatusReport) -> StatusReport {
        StatusReport { mode: status.mode.with_alarm_of(self.state.mode), ..*status }
    }

    fn count_blocks(&mut self, status: &StatusReport, before: Mode) {
        if let Some(free) = status.free_blocks {
            // Blocks in use are moves in the queue, the running one included.
            self.state.queued = self.info.blocks.saturating_sub(free);
        // One idle report may be older than the move that was just sent.
        } else if (before, status.mode) == (Mode::Idle, Mode::Idle) {
            self.state.queued = 0;
        }
    }

    fn check_mode(
        &mut self,
        status: &StatusReport,
        before: Mode,
        now_s: f64,
    ) -> Result<(), MotionFault> {
        let homing_lost =
            self.state.homed && status.homed == Some(false) && before != Mode::Unknown;
        self.reported_homed = status.homed.unwrap_or(self.reported_homed);
        self.update_homed();
        if let Some(percent) = status.feed_override.filter(|&percent| percent != 100.0) {
            return Err(MotionFault::Override { percent });
        }
        // The controller's own hold button was pressed, or the resume byte was lost.
        let is_foreign = matches!(status.mode, Mode::Hold { .. })
            && !self.holding
            && now_s - self.resumed_s > self.settings.reply_timeout_s;
        let foreign_s =
            if is_foreign { *self.foreign_hold_s.get_or_insert(now_s) } else { f64::INFINITY };
        if !is_foreign {
            self.foreign_hold_s = None;
        }
        match status.mode {
            Mode::Alarm(code) => {
                self.homing_required = true;
                self.update_homed();
                let expected = matches!(before, Mode::Unknown | Mode::Alarm(_));
                if expected { Ok(()) } else { Err(MotionFault::Alarm { code: code.unwrap_or(0) }) }
            }
            _ if homing_lost => Err(MotionFault::Alarm { code: HOMING_REQUIRED }),
            Mode::Home if self.homing == HomingPhase::Settling => Ok(()),
            mode @ Mode::Hold { .. } if now_s - foreign_s >= HOLD_BEFORE_ALARM_S => {
                Err(MotionFault::UnexpectedMode { mode })
            }
            Mode::Idle | Mode::Run | Mode::Hold { .. } => Ok(()),
            mode => Err(MotionFault::UnexpectedMode { mode }),
        }
    }

    fn check_position(&mut self, status: &StatusReport, now_s: f64) -> Result<(), MotionFault> {
        if let Some(offset_mm) =
            status.offset_mm.filter(|offset_mm| offset_mm.iter().any(|&value| value != 0.0))
        {
            let remedy = "G10 L2 P1 X0 Y0 Z0 A0, G92.1 and G49".to_owned();
            return Err(MotionFault::WorkOffset {
                name: "the status report".to_owned(),
                found: format!("{offset_mm:?}"),
                remedy,
            });
        }
        let Some(position_mm) = status.position_mm else { return Err(MotionFault::no_position()) };
        // Positions mean nothing before homing.
        if !self.state.homed {
            return Ok(());
        }
        if !matches!(status.mode, Mode::Idle | Mode::Run | Mode::Hold { .. }) {
            return Ok(());
        }
        motion_monitor::within_travel(&position_mm, &self.settings)?;
        let idle = status.mode == Mode::Idle;
        if idle && self.homing == HomingPhase::Settling {
            self.homing = HomingPhase::No;
        }
        if !self.commanded_path.is_known() {
            self.stall_detector.restart(now_s);
            if idle || status.mode == (Mode::Hold { complete: true }) {
                self.commanded_path.start(position_mm);
            }
            return Ok(());
        }
        let standing = idle && self.pending.is_none() && self.state.queued == 0;
        // After a hold the axes may stand short of their target until the resume is confirmed.
        if standing && (self.holding || self.complete_short_move(&position_mm, now_s)) {
            return Ok(());
        }
        self.commanded_path.check(position_mm, standing)?;
        self.check_stall(status.mode, position_mm, now_s)
    }

    /// Checks that a controller with pending moves moves; time is measured between its reports.
    fn check_stall(
        &mut self,
        mode: Mode,
        position_mm: [f64; 4],
        now_s: f64,
    ) -> Result<(), MotionFault> {
        let queued = self.state.queued;
        let due = !self.holding && (mode == Mode::Run || (mode == Mode::Idle && queued > 0));
        let stalled_s = self.stall_detector.add_report(due, position_mm, queued, now_s);
        if stalled_s < self.settings.reply_timeout_s.max(MIN_STALL_S) {
            return Ok(());
        }
        match self.commanded_path.farthest_axis(&position_mm) {
            Some((axis, _)) => Err(self.commanded_path.not_moving(axis, &position_mm)),
            None => Ok(()),
        }
    }
}
