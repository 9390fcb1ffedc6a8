//! What each reply of the controller changes.

use super::controller::Controller;
use super::fault::MotionFault;
use super::motion_monitor;
use super::parser::{ReceivedLine, Reply, StatusReport, parse};
use super::pending::{HomingPhase, LinePurpose, PendingLine};
use super::state::Mode;

/// Unreadable lines within [`GARBLED_S`] that make a fault.
const MOST_GARBLED: usize = 3;
/// See [`MOST_GARBLED`], seconds.
const GARBLED_S: f64 = 10.0;
/// Axes that should move and have not for so long, or for as long as an answer may take if that is longer, do not, s.
const STILL_S: f64 = 0.3;
/// The alarm of a controller that wants to be homed.
const HOMING_REQUIRED: u16 = 11;

impl Controller {
    /// Takes everything that has arrived.
    pub(super) fn read(&mut self, now_s: f64) {
        let (pieces, gone) = self.port.read();
        for piece in pieces {
            self.state.last_reply_s = now_s;
            match piece {
                ReceivedLine::Line(line) => match parse(&line) {
                    Some(reply) => self.take(reply, now_s),
                    None => self.garbled(line, now_s),
                },
                ReceivedLine::Garbled(line) => self.garbled(line, now_s),
            }
        }
        if let Err(error) = gone {
            self.fault = Some(MotionFault::unplugged(&error));
            self.fail(MotionFault::unplugged(&error));
        }
    }

    fn take(&mut self, reply: Reply, now_s: f64) {
        match reply {
            Reply::Ok => self.acknowledged(),
            Reply::Error(code) => self.refused(code),
            Reply::Alarm(code) => self.alarmed(code),
            Reply::Boot(greeting) => self.booted(greeting, now_s),
            Reply::Status(status) => self.reported(&status, now_s),
            Reply::Info { name, text } if name == "MSG" && !text.is_empty() => self.state.message = text,
            Reply::Info { .. } | Reply::Setting { .. } | Reply::StartupBlock(_) => {}
        }
    }

    fn garbled(&mut self, line: String, now_s: f64) {
        self.state.garbled += 1;
        // It may have been the report that is awaited: ask again.
        self.asked_s = None;
        self.garbled_s.retain(|&then_s| now_s - then_s <= GARBLED_S);
        self.garbled_s.push_back(now_s);
        let count = self.garbled_s.len();
        if count >= MOST_GARBLED {
            self.garbled_s.clear();
            self.fail(MotionFault::Garbled { count, line });
        }
    }

    fn answered(&mut self) -> Option<PendingLine> {
        self.state.unacknowledged = 0;
        self.pending.take()
    }

    fn acknowledged(&mut self) {
        // Lines from before a reset or a fault may still be answered.
        if self.reset_s.is_some() || self.fault.is_some() {
            return;
        }
        match self.answered().map(|pending| pending.purpose) {
            Some(LinePurpose::Move) => self.state.queued += 1,
            Some(LinePurpose::Setup) => self.set_up = true,
            Some(LinePurpose::Homing) => {
                self.homing = HomingPhase::Settling;
                self.says_homed = true;
                self.must_home = false;
                self.set_up = false;
                self.state.queued = 0;
                self.note_homed();
            }
            None => self.fail(MotionFault::StrayOk),
        }
    }

    fn refused(&mut self, code: u16) {
        if self.reset_s.is_some() {
            return;
        }
        let line = self.answered().map_or_else(|| "(nothing)".to_owned(), |pending| pending.line);
        self.fail(MotionFault::Error { code, line });
    }

    fn alarmed(&mut self, code: u16) {
        let expected = match self.state.mode {
            _ if self.reset_s.is_some() => true,
            Mode::Unknown => true,
            Mode::Alarm(known) => known == Some(code) || code == HOMING_REQUIRED,
            _ => false,
        };
        self.state.mode = Mode::Alarm(Some(code));
        self.must_home = true;
        self.path.forget();
        self.note_homed();
        if !expected {
            self.fail(MotionFault::Alarm { code });
        }
    }

    fn booted(&mut self, greeting: String, now_s: f64) {
        let awaited = self.reset_s.take().is_some();
        let expected = awaited || (self.pending.is_none() && now_s <= self.greetings_until_s);
        // A second greeting may just as well be that of a controller that lost its power.
        self.must_home |= !awaited;
        let homing = self.homing;
        self.start_over();
        if expected && homing == HomingPhase::Wanted {
            self.homing = homing;
        }
        self.next_ask_s = now_s;
        if !expected {
            self.fail(MotionFault::Rebooted { greeting });
        }
    }

    pub(super) fn reported(&mut self, status: &StatusReport, now_s: f64) {
        let status = &self.completed(status);
        self.asked_s = None;
        self.state.last_status_s = now_s;
        self.state.pins = status.pins;
        let before = std::mem::replace(&mut self.state.mode, status.mode);
        self.state.position_mm = status.position_mm.unwrap_or(self.state.position_mm);
        self.state.feed_mm_min = status.feed_mm_min.unwrap_or(self.state.feed_mm_min);
        if self.homing == HomingPhase::Running {
            // An alarm whose own line was not readable; one from before homing may still be on its way.
            let begun =
                self.pending.as_ref().is_some_and(|homing| now_s - homing.sent_s > self.settings.reply_timeout_s);
            if let Mode::Alarm(Some(code)) = status.mode
                && code != HOMING_REQUIRED
                && begun
            {
                return self.fail(MotionFault::Alarm { code });
            }
            self.state.mode = Mode::Home;
            return;
        }
        self.count_blocks(status, before);
        if self.reset_s.is_some() {
            return;
        }
        if let Err(fault) = self.judge_mode(status, before, now_s).and_then(|()| self.judge_position(status, now_s)) {
            self.fail(fault);
        }
    }

    /// A hold that does not tell whether it has come to its end has when two reports name the same position.
    fn completed(&self, status: &StatusReport) -> StatusReport {
        let stands = status.position_mm == Some(self.state.position_mm);
        let held = matches!(self.state.mode, Mode::Hold { .. });
        let mode = if status.bare_hold && held { Mode::Hold { complete: stands } } else { status.mode };
        StatusReport { mode, ..*status }
    }

    fn count_blocks(&mut self, status: &StatusReport, before: Mode) {
        if let Some(free) = status.free_blocks {
            self.state.queued = self.machine.blocks.saturating_sub(free);
        } else if (before, status.mode) == (Mode::Idle, Mode::Idle) {
            self.state.queued = 0;
        }
    }

    fn judge_mode(&mut self, status: &StatusReport, before: Mode, now_s: f64) -> Result<(), MotionFault> {
        let lost = self.state.homed && status.homed == Some(false) && before != Mode::Unknown;
        self.says_homed = status.homed.unwrap_or(self.says_homed);
        self.note_homed();
        if let Some(percent) = status.feed_override.filter(|&percent| percent != 100.0) {
            return Err(MotionFault::Override { percent });
        }
        match status.mode {
            Mode::Alarm(code) => {
                self.must_home = true;
                self.note_homed();
                let expected = matches!(before, Mode::Unknown | Mode::Alarm(_));
                if expected { Ok(()) } else { Err(MotionFault::Alarm { code: code.unwrap_or(0) }) }
            }
            _ if lost => Err(MotionFault::Alarm { code: HOMING_REQUIRED }),
            Mode::Home if self.homing == HomingPhase::Settling => Ok(()),
            // Somebody has pressed the controller's own hold, or the word to go on got lost.
            mode @ Mode::Hold { .. } if !self.held && now_s - self.resumed_s > self.settings.reply_timeout_s => {
                Err(MotionFault::UnexpectedMode { mode })
            }
            Mode::Idle | Mode::Run | Mode::Hold { .. } => Ok(()),
            mode => Err(MotionFault::UnexpectedMode { mode }),
        }
    }

    fn judge_position(&mut self, status: &StatusReport, now_s: f64) -> Result<(), MotionFault> {
        if let Some(offset_mm) = status.offset_mm.filter(|offset_mm| offset_mm.iter().any(|&value| value != 0.0)) {
            let remedy = "G10 L2 P1 X0 Y0 Z0 A0, G92.1 and G49".to_owned();
            return Err(MotionFault::WorkOffset {
                name: "its status".to_owned(),
                found: format!("{offset_mm:?}"),
                remedy,
            });
        }
        let Some(position_mm) = status.position_mm else { return Err(MotionFault::no_position()) };
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
        if !self.path.is_known() {
            self.stillness.begin_again(now_s);
            if idle || status.mode == (Mode::Hold { complete: true }) {
                self.path.start(position_mm);
            }
            return Ok(());
        }
        self.path.check(position_mm, idle && self.pending.is_none() && self.state.queued == 0)?;
        self.judge_stillness(status.mode, position_mm, now_s)
    }

    /// A controller that has somewhere to go goes there: the times for which it does not are those of its answers.
    fn judge_stillness(&mut self, mode: Mode, position_mm: [f64; 4], now_s: f64) -> Result<(), MotionFault> {
        let queued = self.state.queued;
        let due = !self.held && (mode == Mode::Run || (mode == Mode::Idle && queued > 0));
        let still_s = self.stillness.take(due, position_mm, queued, now_s);
        if still_s < self.settings.reply_timeout_s.max(STILL_S) {
            return Ok(());
        }
        match self.path.ahead(&position_mm) {
            Some((axis, target_mm)) => Err(MotionFault::NotMoving { axis, reached_mm: position_mm[axis], target_mm }),
            None => Ok(()),
        }
    }
}
