//! Periodic transmissions and deadlines.

use super::controller::Controller;
use super::fault::MotionFault;
use super::pending::{HomingPhase, LinePurpose, PendingLine};
use super::settings::GREETING_S;
use super::state::Mode;

/// Interval of status queries, s.
const QUERY_INTERVAL_S: f64 = 0.05;
/// Times after which an unanswered query is sent again, s: half of `late_s` within these, because
/// single bytes are lost on real lines.
const REPEATED_QUERY_S: [f64; 2] = [0.05, 0.25];
/// Millimetres, absolute positions, feed per minute, first work coordinate system.
const SETUP: &str = "G21 G90 G94 G54";

impl Controller {
    /// Records a fault for every deadline that has passed. A held controller reads no further lines,
    /// and its answers to queries prove that it is there.
    pub(crate) fn check_deadlines(&mut self, now_s: f64) {
        let reply_s = self.settings.reply_timeout_s;
        if let Some(pending) = &self.pending {
            let waited_s = pending.waited_s(now_s);
            if pending.purpose == LinePurpose::Homing {
                if waited_s > self.settings.homing_timeout_s {
                    self.record_fault(MotionFault::HomingTimeout { waited_s });
                }
            } else if waited_s > reply_s {
                let fault = self.no_answer(pending.line.clone(), waited_s, now_s);
                self.record_fault(fault);
            }
        }
        if let Some(waited_s) = self
            .query_sent_s
            .map(|query_sent_s| now_s - query_sent_s)
            .filter(|&waited_s| waited_s > reply_s)
        {
            let fault = self.no_answer("a status query".to_owned(), waited_s, now_s);
            self.record_fault(fault);
        }
        let reset_waited_s = self.reset_sent_s.map(|reset_sent_s| now_s - reset_sent_s);
        if let Some(waited_s) = reset_waited_s.filter(|&waited_s| waited_s > reply_s + GREETING_S) {
            self.reset_sent_s = None;
            let fault = self.no_answer("a reset".to_owned(), waited_s, now_s);
            self.record_fault(fault);
        }
    }

    /// The fault for an answer that has not arrived: unreadable bytes, if such have arrived in its
    /// place, else silence.
    fn no_answer(&self, to: String, waited_s: f64, now_s: f64) -> MotionFault {
        let garbled = self.last_garbled.as_ref().filter(|(then_s, _)| now_s - then_s <= waited_s);
        match self.port.noise().or_else(|| garbled.map(|(_, line)| line.clone())) {
            Some(line) => MotionFault::Noise { to, line, waited_s },
            None => MotionFault::Silent { to, waited_s },
        }
    }

    /// How long an answer has been outstanding, s; 0 when none is, or during homing, when the
    /// controller may be silent. A held controller answers queries only: the time of a line stands
    /// still.
    pub fn waiting_s(&self, now_s: f64) -> f64 {
        let line = self.pending.as_ref().filter(|pending| pending.purpose != LinePurpose::Homing);
        let line_s = line.map(|pending| pending.waited_s(now_s));
        let query_s = self.query_sent_s.map(|sent_s| now_s - sent_s);
        line_s.into_iter().chain(query_s).fold(0.0, f64::max)
    }

    /// Sends what is due.
    pub(crate) fn send_due(&mut self, now_s: f64) {
        self.start_homing_if_free(now_s);
        // A controller that restarts or homes does not answer.
        let quiet = self.reset_sent_s.is_some() || self.homing == HomingPhase::Running;
        if quiet || matches!(self.fault, Some(MotionFault::Unplugged { .. })) {
            return;
        }
        let standing = self.state.mode == Mode::Idle || self.homing == HomingPhase::Settling;
        if !self.setup_acknowledged
            && self.state.homed
            && standing
            && self.pending.is_none()
            && self.fault.is_none()
        {
            self.send(SETUP.to_owned(), LinePurpose::Setup, now_s);
        }
        // Early enough that a lost byte does not hold the robot.
        let repeat_s = (0.5 * self.settings.late_s).clamp(REPEATED_QUERY_S[0], REPEATED_QUERY_S[1]);
        let due = match self.query_sent_s {
            None => now_s >= self.next_query_s,
            Some(_) => now_s - self.last_query_s >= repeat_s,
        };
        if due {
            // The first unanswered query counts: repeats must not postpone the deadline.
            self.query_sent_s.get_or_insert(now_s);
            self.last_query_s = now_s;
            // One that is lost would make all later reports look older than they are.
            self.query_times_s.retain(|&then_s| now_s - then_s <= self.settings.reply_timeout_s);
            self.query_times_s.push_back(now_s);
            self.next_query_s = now_s + QUERY_INTERVAL_S;
            self.send_byte(b'?');
        }
    }

    pub(crate) fn start_homing_if_free(&mut self, now_s: f64) {
        let free = self.pending.is_none()
            && self.reset_sent_s.is_none()
            && self.state.mode != Mode::Unknown;
        if self.homing != HomingPhase::Wanted || !free {
            return;
        }
        self.homing = HomingPhase::Running;
        self.reported_homed = false;
        self.update_homed();
        self.commanded_path.discard();
        self.state.mode = Mode::Home;
        // A query that was already sent is answered after homing, if at all.
        self.query_sent_s = None;
        self.send("$H".to_owned(), LinePurpose::Homing, now_s);
    }

    pub(super) fn send(&mut self, line: String, purpose: LinePurpose, now_s: f64) {
        let sent = self.port.send(&line);
        self.pending = Some(PendingLine::new(line, purpose, now_s));
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
