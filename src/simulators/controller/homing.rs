//! Homing: all axes move to their switches at once, back off, approach slowly, and back off.

use super::{Activity, ControllerFault, SimulatedController, table};

/// Delay before the start, s.
const START_S: f64 = 0.2;
/// Pauses at the switches, s.
const PAUSES_S: f64 = 1.35;
/// Search distance, in travels.
const SEARCH: f64 = 1.5;

/// How far homing has come.
#[derive(Clone, Debug)]
pub(crate) struct HomingProgress {
    /// Remaining delay before motion starts, s.
    wait_s: f64,
    searched_mm: f64,
    /// Remaining time, s, once all switches are found.
    left_s: Option<f64>,
    /// A status query has arrived.
    pub(crate) asked: bool,
}

impl SimulatedController {
    /// Starts homing; on failure returns the error number.
    pub(crate) fn begin_homing(&mut self) -> Result<(), u16> {
        if table::bits(&self.settings, 22) & 1 == 0 {
            return Err(5);
        }
        self.require_standing()?;
        for axis in 0..4 {
            self.injected.take(&ControllerFault::HardLimit(axis));
        }
        self.axes.stop();
        self.homed = false;
        self.activity =
            Activity::Homing(HomingProgress { wait_s: START_S, searched_mm: 0.0, left_s: None, asked: false });
        self.report();
        Ok(())
    }

    /// Advances homing by a short time.
    pub(crate) fn advance_homing(&mut self, duration_s: f64) {
        let Activity::Homing(mut homing) = self.activity.clone() else { return };
        homing.wait_s -= duration_s;
        let result = match homing.left_s {
            _ if homing.wait_s > 0.0 => Ok(()),
            None => self.seek(&mut homing, duration_s),
            Some(left_s) => {
                self.back_off(left_s, duration_s);
                homing.left_s = Some(left_s - duration_s);
                let stuck = (0..4).any(|axis| self.injected.has(&ControllerFault::SwitchStuckClosed(axis)));
                if stuck { Err(8) } else { Ok(()) }
            }
        };
        let done = homing.left_s.is_some_and(|left_s| left_s <= 0.0);
        match result {
            Err(code) => self.fail_homing(code),
            Ok(()) if done => self.end_homing(homing.asked),
            Ok(()) => self.activity = Activity::Homing(homing),
        }
    }

    fn seek(&mut self, homing: &mut HomingProgress, duration_s: f64) -> Result<(), u16> {
        let closed = self.closed_switches();
        let speed_mm_s = table::value(&self.settings, 25) / 60.0;
        if closed == [true; 4] {
            let pull_off_mm = table::value(&self.settings, 27);
            let slow_mm_s = table::value(&self.settings, 24) / 60.0;
            homing.left_s = Some(2.0 * pull_off_mm / speed_mm_s + pull_off_mm / slow_mm_s + PAUSES_S);
            return Ok(());
        }
        let way_mm = speed_mm_s * duration_s;
        homing.searched_mm += way_mm;
        self.axes.turn(closed.map(|closed| if closed { 0.0 } else { -way_mm }));
        let longest_mm = table::of_axes(&self.settings, 130).into_iter().fold(0.0, f64::max);
        if homing.searched_mm > SEARCH * longest_mm { Err(9) } else { Ok(()) }
    }

    /// Moves from the switches towards home.
    fn back_off(&mut self, left_s: f64, duration_s: f64) {
        let share = (duration_s / left_s.max(duration_s)).min(1.0);
        let way_mm = self.axes.screws_mm.map(|position_mm| -position_mm * share);
        self.axes.turn(way_mm);
    }

    fn end_homing(&mut self, asked: bool) {
        self.axes.count_from([0.0; 4]);
        self.homed = true;
        if asked {
            self.report();
        }
        self.activity = Activity::Ready;
        self.closed = self.closed_switches();
        self.reply("[MSG:]");
        self.reply("ok");
    }

    /// A failure resets the controller.
    fn fail_homing(&mut self, code: u16) {
        self.reply(&format!("ALARM:{code}"));
        self.activity = Activity::Ready;
        self.restart(0.1, None);
    }
}
