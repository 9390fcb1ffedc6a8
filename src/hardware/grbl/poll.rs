//! Periodic transmissions and deadlines.

use super::controller::Controller;
use super::fault::MotionFault;
use super::pending::{HomingPhase, LinePurpose, PendingLine};
use super::settings::GREETING_S;
use super::state::Mode;

/// Interval of status queries, s.
const QUERY_INTERVAL_S: f64 = 0.05;
/// Millimetres, absolute positions, feed per minute, first work coordinate system.
const SETUP: &str = "G21 G90 G94 G54";

impl Controller {
    /// Records a fault for every deadline that has passed.
    pub(crate) fn check_deadlines(&mut self, now_s: f64) {
        let reply_s = self.settings.reply_timeout_s;
        if let Some(pending) = &self.pending {
            let waited_s = now_s - pending.sent_s;
            if pending.purpose == LinePurpose::Homing {
                if waited_s > self.settings.homing_timeout_s {
                    self.record_fault(MotionFault::HomingTimeout { waited_s });
                }
            } else if waited_s > reply_s {
                let to = pending.line.clone();
                self.record_fault(MotionFault::Silent { to, waited_s });
            }
        }
        if let Some(waited_s) =
            self.query_sent_s.map(|query_sent_s| now_s - query_sent_s).filter(|&waited_s| waited_s > reply_s)
        {
            self.record_fault(MotionFault::Silent { to: "a status query".to_owned(), waited_s });
        }
        let reset_waited_s = self.reset_sent_s.map(|reset_sent_s| now_s - reset_sent_s);
        if let Some(waited_s) = reset_waited_s.filter(|&waited_s| waited_s > reply_s + GREETING_S) {
            self.reset_sent_s = None;
            self.record_fault(MotionFault::Silent { to: "a reset".to_owned(), waited_s });
        }
    }

    /// How long an answer has been outstanding, s; 0 when none is, or during homing, when the controller may be silent.
    pub fn waiting_s(&self, now_s: f64) -> f64 {
        let line = self.pending.as_ref().filter(|pending| pending.purpose != LinePurpose::Homing);
        let since_s = line.map(|pending| pending.sent_s).into_iter().chain(self.query_sent_s).fold(now_s, f64::min);
        now_s - since_s
    }

    /// Sends what is due.
    pub(crate) fn send_due(&mut self, now_s: f64) {
        self.start_homing_if_free(now_s);
        let quiet = self.reset_sent_s.is_some() || self.homing == HomingPhase::Running;
        if quiet || matches!(self.fault, Some(MotionFault::Unplugged { .. })) {
            return;
        }
        let standing = self.state.mode == Mode::Idle || self.homing == HomingPhase::Settling;
        if !self.setup_acknowledged && self.state.homed && standing && self.pending.is_none() && self.fault.is_none() {
            self.send(SETUP.to_owned(), LinePurpose::Setup, now_s);
        }
        if self.query_sent_s.is_none() && now_s >= self.next_query_s {
            self.query_sent_s = Some(now_s);
            self.next_query_s = now_s + QUERY_INTERVAL_S;
            self.send_byte(b'?');
        }
    }

    pub(crate) fn start_homing_if_free(&mut self, now_s: f64) {
        let free = self.pending.is_none() && self.reset_sent_s.is_none() && self.state.mode != Mode::Unknown;
        if self.homing != HomingPhase::Wanted || !free {
            return;
        }
        self.homing = HomingPhase::Running;
        self.reported_homed = false;
        self.update_homed();
        self.commanded_path.forget();
        self.state.mode = Mode::Home;
        // A query that was already sent is answered after homing, if at all.
        self.query_sent_s = None;
        self.send("$H".to_owned(), LinePurpose::Homing, now_s);
    }

    pub(super) fn send(&mut self, line: String, purpose: LinePurpose, now_s: f64) {
        let sent = self.port.send(&line);
        self.pending = Some(PendingLine { line, sent_s: now_s, purpose });
        self.state.unacknowledged = 1;
        self.state.sent += 1;
        if let Err(error) = sent {
            self.record_fault(MotionFault::unplugged(&error));
        }
    }

    pub(crate) fn send_byte(&mut self, byte: u8) {
        if let Err(error) = self.port.send_byte(byte) {
            self.record_fault(MotionFault::unplugged(&error));
        }
    }
}
