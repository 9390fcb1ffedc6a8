//! Single bytes that are obeyed at once, alarms and restarts.

use super::{Activity, ModalState, SimulatedController, table};

const GREETING: &str = "GrblHAL 1.1f ['$' or '$HELP' for help]";
const PLAIN_GREETING: &str = "Grbl 1.1h ['$' for help]";
/// Time from an alarm to its message, seconds.
const MESSAGE_S: f64 = 0.1;
const HOMING_REQUIRED: u16 = 11;

impl SimulatedController {
    /// Obeys a byte; false when it belongs to a line.
    pub(crate) fn realtime(&mut self, byte: u8) -> bool {
        match byte {
            b'!' | b'~' => self.note(char::from(byte).to_string()),
            0x18 => self.note("^X".to_owned()),
            0x19 | 0x80..=0xff => self.note(format!("\\x{byte:02x}")),
            _ => {}
        }
        match byte {
            b'?' => self.ask(),
            b'!' => self.hold(),
            b'~' => self.go_on(),
            0x18 => self.reset(),
            0x19 => self.stop(),
            0x85 => self.cancel_jog(),
            0x80..=0xff => {}
            _ => return false,
        }
        true
    }

    /// While homing, queries are remembered and answered once at the end.
    fn ask(&mut self) {
        if let Activity::Homing(homing) = &mut self.doing {
            homing.asked = true;
        } else {
            self.report();
        }
    }

    /// Jogs are not held.
    pub(crate) fn hold(&mut self) {
        if matches!(self.doing, Activity::Ready) && !self.jogging {
            self.doing = Activity::Holding;
            self.axes.holding = true;
        }
    }

    fn go_on(&mut self) {
        if matches!(self.doing, Activity::Holding) {
            self.doing = Activity::Ready;
            self.axes.holding = false;
            self.say("[MSG:]");
        }
    }

    fn cancel_jog(&mut self) {
        if self.jogging {
            self.flush();
        }
    }

    /// Stops without losing the position.
    fn stop(&mut self) {
        if matches!(self.doing, Activity::Ready | Activity::Holding) {
            self.doing = Activity::Ready;
            self.flush();
            self.set_modes(ModalState::default());
            self.say("[MSG:Stop]");
        }
    }

    fn flush(&mut self) {
        self.axes.holding = true;
        self.flushing = true;
        self.lines.clear();
    }

    /// What ctrl-X does.
    fn reset(&mut self) {
        let moving = matches!(self.doing, Activity::Ready | Activity::Holding) && self.axes.speed_mm_min() > 0.0;
        let before = match self.doing {
            Activity::Homing(_) => Some(6),
            _ if moving => Some(3),
            Activity::Alarm(code, _) => Some(code),
            _ => None,
        };
        let mut wait_s = 0.0;
        if let Some(code @ (3 | 6)) = before.filter(|_| !matches!(self.doing, Activity::Alarm(..))) {
            self.say(&format!("ALARM:{code}"));
            wait_s = MESSAGE_S;
        }
        // A soft limit stops nothing that has begun to move.
        if before.is_some_and(|code| code != 2) {
            self.homed = false;
        }
        self.restart(wait_s, before);
    }

    /// Greets, and says what keeps it from moving; `alarm` is the one before.
    pub(crate) fn restart(&mut self, wait_s: f64, alarm: Option<u16>) {
        self.axes.stop();
        self.lines.clear();
        self.half_line.clear();
        self.jogging = false;
        self.flushing = false;
        self.last_error = 0;
        self.modes = ModalState::default();
        self.reporting.start_over();
        self.say_after(wait_s, if self.plain { PLAIN_GREETING } else { GREETING });
        let homing_required = table::bits(&self.settings, 22) & 5 == 5 && !self.homed;
        if homing_required {
            if alarm != Some(HOMING_REQUIRED) {
                self.say(&format!("ALARM:{HOMING_REQUIRED}"));
            }
            self.doing = Activity::Alarm(HOMING_REQUIRED, false);
            self.say_after(MESSAGE_S, "[MSG:Homing cycle required]");
        } else if let Some(code) = alarm {
            self.doing = Activity::Alarm(code, false);
            self.say("[MSG:'$H'|'$X' to unlock]");
        } else {
            self.doing = Activity::Ready;
        }
    }

    /// The first start.
    pub(crate) fn start(&mut self) {
        self.closed = self.closed_switches();
        if self.first_boot {
            self.say("error:7");
        }
        self.restart(0.0, None);
    }

    /// Loses everything but the settings.
    pub(crate) fn reboot(&mut self) {
        self.answers.clear();
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
        self.doing = Activity::Alarm(code, true);
        self.reporting.alarmed = true;
        self.say(&format!("ALARM:{code}"));
        self.say_after(MESSAGE_S, "[MSG:Reset to continue]");
    }
}
