//! What leaves by itself, and what must have come by now.

use super::controller::Controller;
use super::fault::MotionFault;
use super::pending::{HomingPhase, LinePurpose, PendingLine};
use super::settings::GREETING_S;
use super::state::Mode;

/// Time between two status queries, seconds.
const ASK_EVERY_S: f64 = 0.05;
/// Millimetres, absolute positions, feed per minute, in the first of the work coordinate systems.
const SETUP: &str = "G21 G90 G94 G54";

impl Controller {
    /// No line is later than it may be.
    pub(crate) fn check_deadlines(&mut self, now_s: f64) {
        let reply_s = self.settings.reply_timeout_s;
        if let Some(pending) = &self.pending {
            let waited_s = now_s - pending.sent_s;
            if pending.purpose == LinePurpose::Homing {
                if waited_s > self.settings.homing_timeout_s {
                    self.fail(MotionFault::HomingTimeout { waited_s });
                }
            } else if waited_s > reply_s {
                let to = pending.line.clone();
                self.fail(MotionFault::Silent { to, waited_s });
            }
        }
        if let Some(waited_s) = self.asked_s.map(|asked_s| now_s - asked_s).filter(|&waited_s| waited_s > reply_s) {
            self.fail(MotionFault::Silent { to: "a status query".to_owned(), waited_s });
        }
        let reset_waited_s = self.reset_s.map(|reset_s| now_s - reset_s);
        if let Some(waited_s) = reset_waited_s.filter(|&waited_s| waited_s > reply_s + GREETING_S) {
            self.reset_s = None;
            self.fail(MotionFault::Silent { to: "a reset".to_owned(), waited_s });
        }
    }

    /// How long the controller has owed an answer, seconds; 0 when it owes none, or while it homes and may be silent.
    pub fn waiting_s(&self, now_s: f64) -> f64 {
        let line = self.pending.as_ref().filter(|pending| pending.purpose != LinePurpose::Homing);
        let since_s = line.map(|pending| pending.sent_s).into_iter().chain(self.asked_s).fold(now_s, f64::min);
        now_s - since_s
    }

    /// Sends what is due.
    pub(crate) fn go_on(&mut self, now_s: f64) {
        self.home_if_free(now_s);
        let quiet = self.reset_s.is_some() || self.homing == HomingPhase::Running;
        if quiet || matches!(self.fault, Some(MotionFault::Unplugged { .. })) {
            return;
        }
        let standing = self.state.mode == Mode::Idle || self.homing == HomingPhase::Settling;
        if !self.set_up && self.state.homed && standing && self.pending.is_none() && self.fault.is_none() {
            self.send(SETUP.to_owned(), LinePurpose::Setup, now_s);
        }
        if self.asked_s.is_none() && now_s >= self.next_ask_s {
            self.asked_s = Some(now_s);
            self.next_ask_s = now_s + ASK_EVERY_S;
            self.send_byte(b'?');
        }
    }

    pub(crate) fn home_if_free(&mut self, now_s: f64) {
        let free = self.pending.is_none() && self.reset_s.is_none() && self.state.mode != Mode::Unknown;
        if self.homing != HomingPhase::Wanted || !free {
            return;
        }
        self.homing = HomingPhase::Running;
        self.says_homed = false;
        self.note_homed();
        self.path.forget();
        self.state.mode = Mode::Home;
        // A query that is on its way is answered when homing has ended, if at all.
        self.asked_s = None;
        self.send("$H".to_owned(), LinePurpose::Homing, now_s);
    }

    pub(super) fn send(&mut self, line: String, purpose: LinePurpose, now_s: f64) {
        let sent = self.port.send(&line);
        self.pending = Some(PendingLine { line, sent_s: now_s, purpose });
        self.state.unacknowledged = 1;
        self.state.sent += 1;
        if let Err(error) = sent {
            self.fail(MotionFault::unplugged(&error));
        }
    }

    pub(crate) fn send_byte(&mut self, byte: u8) {
        if let Err(error) = self.port.send_byte(byte) {
            self.fail(MotionFault::unplugged(&error));
        }
    }
}
