//! Real-time bytes, alarms and restarts.

use rand::RngExt;

use super::{Activity, ControllerFault, ModalState, SimulatedController, table};

const GREETING: &str = "GrblHAL 1.1f ['$' or '$HELP' for help]";
const PLAIN_GREETING: &str = "Grbl 1.1h ['$' for help]";
/// Time from an alarm to its message, s.
const MESSAGE_S: f64 = 0.1;
const HOMING_REQUIRED: u16 = 11;

impl SimulatedController {
    /// Executes a real-time byte; false for a byte of a line.
    pub(crate) fn realtime(&mut self, byte: u8) -> bool {
        match byte {
            b'!' | b'~' => self.log_received(char::from(byte).to_string()),
            0x18 => self.log_received("^X".to_owned()),
            0x19 | 0x80..=0xff => self.log_received(format!("\\x{byte:02x}")),
            _ => {}
        }
        match byte {
            b'?' => self.answer_query(),
            b'!' => self.hold(),
            b'~' => self.resume(),
            0x18 => self.reset(),
            0x19 => self.stop(),
            0x85 => self.cancel_jog(),
            0x87 if !self.plain => self.full_report(),
            0x80..=0xff => {}
            _ => return false,
        }
        true
    }

    /// During homing, queries are remembered and answered once at the end. Some are lost.
    fn answer_query(&mut self) {
        let lost = self.lost_queries > 0.0 && self.random.random::<f64>() < self.lost_queries;
        if lost || self.injected.take(&ControllerFault::LostQuery) {
            return;
        }
        if let Activity::Homing(homing) = &mut self.activity {
            homing.query_pending = true;
        } else {
            self.report();
        }
    }

    /// Jogs are not held.
    pub(crate) fn hold(&mut self) {
        if matches!(self.activity, Activity::Ready) && !self.jogging {
            self.activity = Activity::Holding;
            self.axes.hold(true);
        }
    }

    /// Ignored until the hold is complete, as grblHAL does.
    fn resume(&mut self) {
        let complete = matches!(self.activity, Activity::Holding) && !self.axes.is_stopping();
        if complete && !self.injected.has(&ControllerFault::IgnoredResume) {
            self.activity = Activity::Ready;
            self.axes.resume();
            self.reply("[MSG:]");
        }
    }

    fn cancel_jog(&mut self) {
        if self.jogging {
            self.flush();
        }
    }

    /// Stops without losing the position.
    fn stop(&mut self) {
        if matches!(self.activity, Activity::Ready | Activity::Holding) {
            self.activity = Activity::Ready;
            self.flush();
            self.set_modes(ModalState::default());
            self.reply("[MSG:Stop]");
        }
    }

    fn flush(&mut self) {
        self.axes.hold(false);
        self.flushing = true;
        self.lines.clear();
    }

    /// The effect of Ctrl-X.
    fn reset(&mut self) {
        let moving = matches!(self.activity, Activity::Ready | Activity::Holding)
            && self.axes.speed_mm_min() > 0.0;
        // A reset while homing (6) or in motion (3) loses the position.
        let before = match self.activity {
            Activity::Homing(_) => Some(6),
            _ if moving => Some(3),
            Activity::Alarm(code, _) => Some(code),
            _ => None,
        };
        let mut wait_s = 0.0;
        if let Some(code @ (3 | 6)) =
            before.filter(|_| !matches!(self.activity, Activity::Alarm(..)))
        {
            self.reply(&format!("ALARM:{code}"));
            wait_s = MESSAGE_S;
        }
        // After a soft limit no motion was interrupted, so the position is kept.
        if before.is_some_and(|code| code != 2) {
            self.homed = false;
        }
        self.restart(wait_s, before);
    }

    /// Greets and reports what blocks motion; `alarm` is the alarm before.
    pub(crate) fn restart(&mut self, wait_s: f64, alarm: Option<u16>) {
        self.axes.stop();
        self.lines.clear();
        self.partial_line.clear();
        self.jogging = false;
        self.flushing = false;
        self.last_error = 0;
        self.modes = ModalState::default();
        self.reporting.start_over();
        self.reply_after(wait_s, if self.plain { PLAIN_GREETING } else { GREETING });
        let homing_required = table::homing_required(&self.settings) && !self.homed;
        if homing_required {
            if alarm != Some(HOMING_REQUIRED) {
                self.reply(&format!("ALARM:{HOMING_REQUIRED}"));
            }
            self.activity = Activity::Alarm(HOMING_REQUIRED, false);
            self.reply_after(MESSAGE_S, "[MSG:Homing cycle required]");
        } else if let Some(code) = alarm {
            self.activity = Activity::Alarm(code, false);
            self.reply("[MSG:'$H'|'$X' to unlock]");
        } else {
            self.activity = Activity::Ready;
        }
    }

    /// The first start-up.
    pub(crate) fn start(&mut self) {
        self.closed = self.closed_switches();
        if self.first_boot {
            self.reply("error:7");
        }
        self.restart(0.0, None);
    }

    /// Loses all state except the settings.
    pub(crate) fn reboot(&mut self) {
        self.replies.clear();
        self.homed = false;
        self.offset_mm = [0.0; 4];
        self.axes.count_from([0.0; 4]);
        self.restart(0.0, None);
    }

    /// Stops everything until a reset.
    pub(crate) fn alarm(&mut self, code: u16) {
        self.axes.halt();
        self.jogging = false;
        self.flushing = false;
        self.activity = Activity::Alarm(code, true);
        self.reporting.alarmed = true;
        self.reply(&format!("ALARM:{code}"));
        self.reply_after(MESSAGE_S, "[MSG:Reset to continue]");
    }
}
