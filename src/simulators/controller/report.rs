//! Reports of the simulated controller.

use super::{Activity, ControllerFault, MAX_QUEUED_MOVES, SimulatedController, table};
use crate::hardware::grbl::AXIS_NAMES;

/// Reports between two that carry the work offset.
const OFFSET_EVERY: u32 = 30;
/// Reports between two that carry the overrides.
const OVERRIDES_EVERY: u32 = 20;

/// What the next report has to carry.
#[derive(Clone, Debug)]
pub(crate) struct ReportState {
    /// Reports since the start.
    count: u32,
    /// The homing state reported last.
    homed: bool,
    pub(crate) modes_changed: bool,
    pub(crate) alarmed: bool,
    /// It has to name the alarm, whatever `$10` says.
    full: bool,
}

impl Default for ReportState {
    fn default() -> Self {
        ReportState { count: 0, homed: false, modes_changed: true, alarmed: false, full: false }
    }
}

impl ReportState {
    /// State after a reset.
    pub(crate) fn start_over(&mut self) {
        *self = ReportState { homed: self.homed, ..ReportState::default() };
    }
}

impl SimulatedController {
    /// Answers `?`.
    pub(crate) fn report(&mut self) {
        let status = match self
            .injected
            .last_status
            .take()
            .filter(|_| self.injected.has(&ControllerFault::Frozen))
        {
            Some(last) => last,
            None => self.status(),
        };
        self.reply(&status);
        self.injected.last_status = Some(status);
        let parser_state = table::bits(&self.settings, 10) & 512 != 0;
        if std::mem::take(&mut self.reporting.modes_changed) && parser_state {
            let text = self.modes.text();
            self.reply(&text);
        }
    }

    /// Answers 0x87.
    pub(crate) fn full_report(&mut self) {
        self.reporting.full = true;
        self.report();
        self.reporting.full = false;
    }

    fn status(&mut self) -> String {
        let steps_per_mm = table::of_axes(&self.settings, 100);
        let mut counted_mm = self.axes.counted_mm;
        if let Some(earlier_s) = self.injected.torn_s.take_if(|_| self.axes.speed_mm_min() > 0.0) {
            counted_mm[3] = self.axes.counted_before_mm(earlier_s)[3];
        }
        let counted_mm = self.mirrored_mm(counted_mm);
        let position_mm = std::array::from_fn(|axis| {
            let steps_per_mm = steps_per_mm[axis].max(1.0);
            (counted_mm[axis] * steps_per_mm).round() / steps_per_mm
        });
        let (free, room) = (MAX_QUEUED_MOVES - self.axes.queued().min(MAX_QUEUED_MOVES), 1023);
        let feed = self.axes.speed_mm_min().round();
        if self.plain {
            return self.plain_status(&position_mm, feed);
        }
        let which =
            if self.injected.has(&ControllerFault::WorkPositions) { "WPos" } else { "MPos" };
        let mut position = format_axes(&position_mm);
        if self.injected.has(&ControllerFault::ThreeAxes) {
            position.truncate(position.rfind(',').unwrap_or_default());
        }
        let mut text = format!("<{}|{which}:{position}|Bf:{free},{room}|FS:{feed},0", self.mode());
        self.add_changes(&mut text);
        text.push('>');
        text
    }

    /// Report of plain GRBL: `$10` bit 2 adds the queue, the work offset is sent now and then.
    fn plain_status(&mut self, position_mm: &[f64; 4], feed: f64) -> String {
        let mut text = format!("<{}|FS:{feed},0|MPos:{}", self.mode(), format_axes(position_mm));
        if table::bits(&self.settings, 10) & 2 != 0 {
            text.push_str(&format!(
                "|Bf:{},128",
                MAX_QUEUED_MOVES - self.axes.queued().min(MAX_QUEUED_MOVES)
            ));
        }
        match self.reporting.count % OFFSET_EVERY {
            0 => text.push_str(&format!("|WCO:{}", format_axes(&self.offset_mm))),
            1 => text.push_str("|Ov:100,100,100"),
            2 => text.push_str("|Ln:12|Pn:P"),
            _ => {}
        }
        self.reporting.count += 1;
        text.push('>');
        text
    }

    /// Adds the fields that are sent only on changes or periodically.
    fn add_changes(&mut self, text: &mut String) {
        let count = self.reporting.count;
        self.reporting.count += 1;
        let closed = self.closed_switches();
        if closed.contains(&true) {
            text.push_str("|Pn:");
            text.extend((0..4).filter(|&axis| closed[axis]).map(|axis| AXIS_NAMES[axis]));
        }
        if count % OFFSET_EVERY == 1 {
            text.push_str(&format!("|WCO:{}", format_axes(&self.offset_mm)));
        } else if let Some(percent) = self.injected.feed_percent {
            text.push_str(&format!("|Ov:{percent},100,100"));
        } else if count.is_multiple_of(OVERRIDES_EVERY) {
            text.push_str("|Ov:100,100,100");
        }
        if std::mem::take(&mut self.reporting.alarmed) || count == 0 {
            text.push_str("|A:");
        }
        let homing = matches!(self.activity, Activity::Homing(_));
        if (self.reporting.homed != self.homed || self.injected.has(&ControllerFault::TellsHomed))
            && !homing
        {
            self.reporting.homed = self.homed;
            text.push_str(&format!("|H:{}", u8::from(self.homed)));
        }
        if count == 0 {
            text.push_str("|TLR:0");
        }
    }

    fn mode(&self) -> String {
        let substates = table::bits(&self.settings, 10) & 1024 != 0 || self.reporting.full;
        match self.activity {
            Activity::Ready if self.axes.queued() == 0 => "Idle".to_owned(),
            Activity::Ready if self.jogging => "Jog".to_owned(),
            Activity::Ready => "Run".to_owned(),
            Activity::Holding if self.plain => "Hold".to_owned(),
            Activity::Holding => format!("Hold:{}", u8::from(self.axes.is_stopping())),
            Activity::Homing(_) => "Home".to_owned(),
            Activity::Alarm(code, _) if substates => format!("Alarm:{code}"),
            Activity::Alarm(..) => "Alarm".to_owned(),
        }
    }

    /// Answers `$I`.
    pub(crate) fn identify(&mut self) {
        if self.plain {
            self.reply("[VER:1.1h.20190830:another]");
            return self.reply("[OPT:V]");
        }
        let lines = [
            "[VER:1.1f.20260817:]",
            "[OPT:VNML+,100,1024,4,0]",
            "[AXS:4:XYZA]",
            "[NEWOPT:ENUMS,RT+,TC,SED]",
            "[FIRMWARE:grblHAL]",
            "[SIGNALS:D]",
            "[NVS STORAGE:*EEPROM]",
            "[DRIVER:Simulator]",
            "[DRIVER VERSION:260324]",
        ];
        lines.iter().for_each(|line| self.reply(line));
    }

    /// Answers `$$`.
    pub(crate) fn list_settings(&mut self) {
        let lines: Vec<String> =
            self.settings.iter().map(|(number, value)| format!("${number}={value}")).collect();
        lines.iter().for_each(|line| self.reply(line));
    }

    /// Answers `$#`.
    pub(crate) fn list_offsets(&mut self) {
        let none = format_axes(&[0.0; 4]);
        for name in
            ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3", "G28", "G30"]
        {
            self.reply(&format!("[{name}:{none}]"));
        }
        let offset = format_axes(&self.offset_mm);
        self.reply(&format!("[G92:{offset}]"));
        let axes = if self.homed { 15 } else { 0 };
        self.reply(&format!("[HOME:{none}:{axes}]"));
        self.reply(&if self.plain { "[TLO:0.000]".to_owned() } else { format!("[TLO:{none}]") });
        self.reply(&format!("[PRB:{none}:0]"));
    }
}

/// Formats four numbers as in reports.
fn format_axes(values: &[f64; 4]) -> String {
    values.map(|value| format!("{:.3}", value + 0.0)).join(",")
}
