//! Homing: all axes move to their switches at once, back off, approach slowly, and back off.

use super::{Activity, ControllerFault, SimulatedController, table};

/// Delay before the start, s.
const START_S: f64 = 0.2;
/// Pauses at the switches, s.
const PAUSES_S: f64 = 1.35;
/// Search distance, in travels.
const MAX_SEARCH_TRAVELS: f64 = 1.5;

/// How far homing has come.
#[derive(Clone, Debug)]
pub(crate) struct HomingProgress {
    /// Remaining delay before motion starts, s.
    wait_s: f64,
    searched_mm: f64,
    /// Remaining time, s, once all switches are found.
    remaining_s: Option<f64>,
    /// A status query has arrived.
    pub(crate) query_pending: bool,
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
        self.activity = Activity::Homing(HomingProgress {
            wait_s: START_S,
            searched_mm: 0.0,
            remaining_s: None,
            query_pending: false,
        });
        self.report();
        Ok(())
    }

    /// Advances homing by a short time.
    pub(crate) fn advance_homing(&mut self, duration_s: f64) {
        let Activity::Homing(mut homing) = self.activity.clone() else { return };
        homing.wait_s -= duration_s;
        let result = match homing.remaining_s {
            _ if homing.wait_s > 0.0 => Ok(()),
            None => self.seek(&mut homing, duration_s),
            Some(remaining_s) => {
                self.back_off(remaining_s, duration_s);
                homing.remaining_s = Some(remaining_s - duration_s);
                let stuck =
                    (0..4).any(|axis| self.injected.has(&ControllerFault::SwitchStuckClosed(axis)));
                if stuck { Err(8) } else { Ok(()) }
            }
        };
        let done = homing.remaining_s.is_some_and(|remaining_s| remaining_s <= 0.0);
        match result {
            Err(code) => self.fail_homing(code),
            Ok(()) if done => self.end_homing(homing.query_pending),
            Ok(()) => self.activity = Activity::Homing(homing),
        }
    }

    fn seek(&mut self, homing: &mut HomingProgress, duration_s: f64) -> Result<(), u16> {
        let closed = self.closed_switches();
        let speed_mm_s = table::value(&self.settings, 25) / 60.0;
        if closed == [true; 4] {
            let pull_off_mm = table::value(&self.settings, 27);
            let slow_mm_s = table::value(&self.settings, 24) / 60.0;
            // Two back-offs at the search speed, one slow approach, and the pauses.
            homing.remaining_s =
                Some(2.0 * pull_off_mm / speed_mm_s + pull_off_mm / slow_mm_s + PAUSES_S);
            return Ok(());
        }
        let way_mm = speed_mm_s * duration_s;
        homing.searched_mm += way_mm;
        self.axes.turn(closed.map(|closed| if closed { 0.0 } else { -way_mm }));
        let longest_mm = table::of_axes(&self.settings, 130).into_iter().fold(0.0, f64::max);
        if homing.searched_mm > MAX_SEARCH_TRAVELS * longest_mm { Err(9) } else { Ok(()) }
    }

    /// Moves from the switches towards home.
    fn back_off(&mut self, remaining_s: f64, duration_s: f64) {
        let share = (duration_s / remaining_s.max(duration_s)).min(1.0);
        let way_mm = self.axes.screws_mm.map(|position_mm| -position_mm * share);
        self.axes.turn(way_mm);
    }

    fn end_homing(&mut self, query_pending: bool) {
        self.axes.count_from([0.0; 4]);
        self.homed = true;
        if query_pending {
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
