//! Execution of lines: settings, `$` commands and G-code.

use super::gcode;
use super::gcode::GcodeAction;
use super::{Activity, ModalState, SimulatedController, table};
use crate::simulators::axes::MotionLimits;

/// Reply to a line.
enum LineReply {
    Ok,
    /// No reply yet.
    Later,
}

impl SimulatedController {
    /// Executes a line and replies to it.
    pub(crate) fn execute_line(&mut self, line: Result<String, u16>) {
        match line.and_then(|line| self.execute(&line)) {
            Ok(LineReply::Ok) => self.reply("ok"),
            Ok(LineReply::Later) => {}
            Err(code) => {
                self.last_error = code;
                self.reply(&format!("error:{code}"));
            }
        }
    }

    fn execute(&mut self, line: &str) -> Result<LineReply, u16> {
        if line.is_empty() {
            self.last_error = 0;
            return Ok(LineReply::Ok);
        }
        if let Some(command) = line.strip_prefix('$') {
            let answer = self.command(command)?;
            self.last_error = 0;
            return Ok(answer);
        }
        if matches!(self.activity, Activity::Alarm(..)) {
            return Err(9);
        }
        if let Some(code) = self.injected.sticky.take() {
            return Err(code);
        }
        if self.last_error != 0 {
            return Err(self.last_error);
        }
        let mut modes = self.modes;
        let action = gcode::apply(&gcode::words(line)?, &mut modes)?;
        self.set_modes(modes);
        match action {
            GcodeAction::Nothing => Ok(LineReply::Ok),
            GcodeAction::Shift(axes) => {
                let here_mm = self.mirrored_mm(self.axes.planned_mm());
                for axis in 0..4 {
                    self.offset_mm[axis] =
                        axes[axis].map_or(self.offset_mm[axis], |value| here_mm[axis] - value);
                }
                Ok(LineReply::Ok)
            }
            GcodeAction::Go(axes) => {
                let target_mm = self.target_mm(axes, &modes, &self.offset_mm);
                if self.soft_limit(&target_mm) {
                    self.alarm(2);
                    return Ok(LineReply::Later);
                }
                self.queue(target_mm, &modes);
                Ok(LineReply::Ok)
            }
        }
    }

    pub(crate) fn set_modes(&mut self, modes: ModalState) {
        self.reporting.modes_changed |= modes != self.modes;
        self.modes = modes;
    }

    fn target_mm(
        &self,
        axes: [Option<f64>; 4],
        modes: &ModalState,
        offset_mm: &[f64; 4],
    ) -> [f64; 4] {
        let from_mm = self.mirrored_mm(self.axes.planned_mm());
        std::array::from_fn(|axis| match axes[axis] {
            None => from_mm[axis],
            Some(way_mm) if modes.incremental => from_mm[axis] + way_mm,
            Some(target_mm) => target_mm + offset_mm[axis],
        })
    }

    /// Soft limits apply to homed axes only.
    fn soft_limit(&self, target_mm: &[f64; 4]) -> bool {
        self.homed && table::bits(&self.settings, 20) & 1 == 1 && self.outside(target_mm)
    }

    fn outside(&self, target_mm: &[f64; 4]) -> bool {
        let travel_mm = table::of_axes(&self.settings, 130);
        let downwards = table::bits(&self.settings, 23);
        (0..4).any(|axis| {
            let (low_mm, high_mm) = if downwards & (1 << axis) == 0 {
                (-travel_mm[axis], 0.0)
            } else {
                (0.0, travel_mm[axis])
            };
            target_mm[axis] < low_mm || target_mm[axis] > high_mm
        })
    }

    /// Converts between screw and machine positions (its own inverse): positions of axes that home
    /// upwards are negative.
    pub(crate) fn mirrored_mm(&self, along_mm: [f64; 4]) -> [f64; 4] {
        let downwards = table::bits(&self.settings, 23);
        let upwards = |axis: usize| self.homed && downwards & (1 << axis) == 0;
        std::array::from_fn(|axis| if upwards(axis) { -along_mm[axis] } else { along_mm[axis] })
    }

    fn queue(&mut self, target_mm: [f64; 4], modes: &ModalState) {
        let target_mm = self.mirrored_mm(target_mm);
        let from_mm = self.axes.planned_mm();
        let steps_per_mm = table::of_axes(&self.settings, 100);
        let steps = |axis: usize, position_mm: f64| (position_mm * steps_per_mm[axis]).round();
        if (0..4).all(|axis| steps(axis, target_mm[axis]) == steps(axis, from_mm[axis])) {
            return;
        }
        let length_mm =
            (0..4).map(|axis| (target_mm[axis] - from_mm[axis]).powi(2)).sum::<f64>().sqrt();
        let feed_mm_min = match modes {
            ModalState { rapid: true, .. } => f64::INFINITY,
            ModalState { inverse_time: true, feed, .. } => feed * length_mm,
            ModalState { inches: true, feed, .. } => feed * 25.4,
            ModalState { feed, .. } => *feed,
        };
        let limits = MotionLimits {
            feed_mm_min,
            max_speed_mm_min: table::of_axes(&self.settings, 110),
            acceleration_mm_s2: table::of_axes(&self.settings, 120),
        };
        self.axes.push(target_mm, &limits);
    }

    fn command(&mut self, command: &str) -> Result<LineReply, u16> {
        match command {
            "H" => return self.begin_homing().map(|()| LineReply::Later),
            "X" => self.unlock()?,
            "I" => self.identify(),
            "$" => {
                self.require_standing()
                    .or_else(|code| if code == 79 { Ok(()) } else { Err(code) })?;
                self.list_settings();
            }
            "#" => self.list_offsets(),
            "G" => {
                let text = self.modes.text();
                self.reply(&text);
            }
            _ if command.starts_with("J=") => self.jog(&command[2..])?,
            _ if command.starts_with(|first: char| first.is_ascii_digit()) => {
                table::write(&mut self.settings, command)?;
            }
            _ => return Err(3),
        }
        Ok(LineReply::Ok)
    }

    /// Refuses commands that require a controller at rest that needs no reset.
    pub(crate) fn require_standing(&self) -> Result<(), u16> {
        match self.activity {
            Activity::Alarm(_, true) => Err(79),
            Activity::Alarm(_, false) => Ok(()),
            Activity::Ready if self.axes.queued() == 0 => Ok(()),
            _ => Err(8),
        }
    }

    fn unlock(&mut self) -> Result<(), u16> {
        let Activity::Alarm(_, needs_reset) = self.activity else { return Ok(()) };
        if needs_reset {
            return Err(79);
        }
        if table::homing_required(&self.settings) && !self.homed {
            return Err(46);
        }
        self.activity = Activity::Ready;
        self.reply("[MSG:Caution: Unlocked]");
        Ok(())
    }

    fn jog(&mut self, line: &str) -> Result<(), u16> {
        match self.activity {
            Activity::Ready if self.jogging || self.axes.queued() == 0 => {}
            Activity::Ready | Activity::Holding | Activity::Homing(_) => return Err(8),
            Activity::Alarm(..) => return Err(9),
        }
        let words = gcode::words(line)?;
        if words.commands.iter().any(|command| ![20.0, 21.0, 53.0, 90.0, 91.0].contains(command)) {
            return Err(16);
        }
        let mut modes = ModalState { rapid: false, feed: 0.0, ..self.modes };
        let GcodeAction::Go(axes) = gcode::apply(&words, &mut modes)? else { return Err(16) };
        let offset_mm = if words.commands.contains(&53.0) { [0.0; 4] } else { self.offset_mm };
        let target_mm = self.target_mm(axes, &modes, &offset_mm);
        if self.homed && self.outside(&target_mm) {
            return Err(15);
        }
        self.queue(target_mm, &modes);
        self.jogging = true;
        Ok(())
    }
}
