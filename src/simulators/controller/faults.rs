//! Faults that can be injected into the simulated controller.

use super::{Activity, SimulatedController};

/// A fault of the controller, its cable or its machine.
#[derive(Clone, Debug, PartialEq)]
pub enum ControllerFault {
    /// It sends nothing any more.
    Silent,
    /// Motion freezes and it repeats its last report.
    Frozen,
    /// It answers this many seconds later than usual.
    SlowReplies(f64),
    /// All its output is unreadable.
    Garbage,
    /// Its next line is unreadable.
    GarbledLine,
    /// An axis neither turns nor counts.
    DeadAxis(usize),
    /// An axis counts its steps but does not turn; the controller cannot detect it.
    SlippingAxis(usize),
    /// A limit switch never closes.
    SwitchStuckOpen(usize),
    /// A limit switch is always closed.
    SwitchStuckClosed(usize),
    /// A limit switch is pressed until the next homing.
    HardLimit(usize),
    /// An alarm without a cause.
    SpuriousAlarm(u16),
    /// The next G-code line is refused with this error, and all further ones until an empty line.
    StickyError(u16),
    /// Power is interrupted briefly.
    Reboot,
    /// The cable is unplugged.
    Unplugged,
    /// The next `ok` is lost.
    LostOk,
    /// The next `ok` is sent twice.
    DoubledOk,
    /// The next `?` is lost.
    LostQuery,
    /// It ignores `~`, as with a hold input that stays closed.
    IgnoredResume,
    /// Bytes that are no line arrive without an end, and nothing else: another baud rate.
    Babble,
    /// The counted position of an axis jumps by this many millimetres.
    WrongPosition(usize, f64),
    /// A motor loses steps: its screw is this many millimetres from where the controller counts it.
    LostSteps(usize, f64),
    /// A work offset of an axis, millimetres.
    WorkOffset(usize, f64),
    /// A setting has another value.
    WrongSettings(u16, String),
    /// The controller's own hold button is pressed.
    HoldButton,
    /// The feed override is changed to this value, per cent.
    FeedOverride(u32),
    /// Every report carries the homing state, as with some firmware; others report it once.
    TellsHomed,
    /// Its reports have three axes.
    ThreeAxes,
    /// The next report during a move gives the last axis where it was this many seconds before the
    /// others.
    TornReport(f64),
    /// It reports work positions instead of machine positions.
    WorkPositions,
}

/// State of the persistent faults.
#[derive(Clone, Debug, Default)]
pub(crate) struct ActiveFaults {
    /// Those without a number.
    list: Vec<ControllerFault>,
    pub(crate) last_status: Option<String>,
    pub(crate) slow_s: f64,
    pub(crate) sticky: Option<u16>,
    pub(crate) feed_percent: Option<u32>,
    /// How much earlier the next report during a move reads the last axis, s.
    pub(crate) torn_s: Option<f64>,
}

impl ActiveFaults {
    pub(crate) fn has(&self, fault: &ControllerFault) -> bool {
        self.list.contains(fault)
    }

    /// Whether it was there; it is gone.
    pub(crate) fn take(&mut self, fault: &ControllerFault) -> bool {
        let before = self.list.len();
        self.list.retain(|other| other != fault);
        self.list.len() < before
    }

    /// The bytes that are sent in place of a line.
    pub(crate) fn corrupt(&mut self, text: &str) -> Vec<Vec<u8>> {
        let mut copies = 1;
        if text == "ok" {
            copies += usize::from(self.take(&ControllerFault::DoubledOk));
            copies -= usize::from(self.take(&ControllerFault::LostOk));
        }
        if self.has(&ControllerFault::Silent) {
            return Vec::new();
        }
        if self.has(&ControllerFault::Babble) {
            return vec![text.bytes().map(|byte| byte ^ 0xa5).collect()];
        }
        let mut bytes = format!("{text}\r\n").into_bytes();
        if self.has(&ControllerFault::Garbage) || self.take(&ControllerFault::GarbledLine) {
            bytes.splice(0..1, [0xff, 0x00, 0xc3]);
        }
        vec![bytes; copies]
    }
}

impl SimulatedController {
    /// Injects a fault.
    pub fn inject(&mut self, fault: ControllerFault) {
        let injected = &mut self.injected;
        match fault {
            ControllerFault::SlowReplies(slow_s) => injected.slow_s = slow_s,
            ControllerFault::DeadAxis(axis) => self.axes.dead[axis] = true,
            ControllerFault::SlippingAxis(axis) => self.axes.slipping[axis] = true,
            ControllerFault::SpuriousAlarm(code) => self.alarm(code),
            ControllerFault::StickyError(code) => injected.sticky = Some(code),
            ControllerFault::Reboot => self.reboot(),
            ControllerFault::Unplugged => self.serial = None,
            ControllerFault::WrongPosition(axis, way_mm) => self.axes.counted_mm[axis] += way_mm,
            ControllerFault::LostSteps(axis, way_mm) => self.axes.screws_mm[axis] += way_mm,
            ControllerFault::WorkOffset(axis, offset_mm) => self.offset_mm[axis] = offset_mm,
            ControllerFault::HoldButton => self.hold(),
            ControllerFault::FeedOverride(percent) => injected.feed_percent = Some(percent),
            ControllerFault::TornReport(earlier_s) => injected.torn_s = Some(earlier_s),
            ControllerFault::WrongSettings(number, value) => {
                self.settings.insert(number, value);
            }
            other => injected.list.push(other),
        }
    }

    /// Clears all persistent faults except an unplugged cable and changed settings.
    pub fn clear_faults(&mut self) {
        self.injected = ActiveFaults::default();
        self.axes.dead = [false; 4];
        self.axes.slipping = [false; 4];
        self.offset_mm = [0.0; 4];
    }

    /// Limit switches that are closed.
    pub(crate) fn closed_switches(&self) -> [bool; 4] {
        let switch_mm = -super::table::value(&self.settings, 27);
        std::array::from_fn(|axis| {
            let pressed = self.injected.has(&ControllerFault::HardLimit(axis))
                || self.axes.screws_mm[axis] <= switch_mm + 1e-9;
            self.injected.has(&ControllerFault::SwitchStuckClosed(axis))
                || (pressed && !self.injected.has(&ControllerFault::SwitchStuckOpen(axis)))
        })
    }

    /// Raises an alarm when a switch closes while hard limits are on.
    pub(crate) fn check_switches(&mut self) {
        let closed = self.closed_switches();
        let hit = (0..4).any(|axis| closed[axis] && !self.closed[axis]);
        self.closed = closed;
        let on = super::table::bits(&self.settings, 21) & 1 == 1;
        if hit && on && matches!(self.activity, Activity::Ready | Activity::Holding) {
            self.alarm(1);
        }
    }
}
