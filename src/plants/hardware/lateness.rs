//! Ends a trial whose ticks are late: a row would be measured at another time than it says.
//!
//! The program may have been paused (a stopped process, a suspended computer, a swapped page), the
//! policy may compute for too long, or the controller answer too slowly. Holds are no lateness: the
//! robot waits as well.

use super::Hardware;
use crate::base::PlantError;
use crate::hardware::rig::Event;

/// When something happened, s, that a hold may have delayed: the start of the first hold among
/// `events`, if that was earlier.
fn before_holds_s(events: &[Event], now_s: f64) -> f64 {
    let held = events.iter().find(|event| event.state == "held");
    held.map_or(now_s, |event| event.time_s.min(now_s))
}

impl Hardware {
    /// Refuses to go on if what was due at `due_s` happened too late at `now_s`, apart from
    /// `excused_s` and from holds since the end of the last tick.
    pub(super) fn check_late(
        &self,
        what: &str,
        due_s: f64,
        now_s: f64,
        excused_s: f64,
    ) -> Result<(), PlantError> {
        let then_s = {
            let rig = self.supervised.rig();
            before_holds_s(&rig.events()[self.seen_events..], now_s)
        };
        let late_s = then_s - due_s - excused_s;
        let max_late_s = self.safety.max_late_ticks * self.step_s;
        if late_s <= max_late_s {
            return Ok(());
        }
        Err(PlantError::Late(format!(
            "{what} came {:.0} ms late, expected at most {:.0} ms (safety.max_late_ticks {}): this \
             program was paused, or the computer or the controller is too slow; the robot has \
             stopped; start the trial again",
            late_s * 1e3,
            max_late_s * 1e3,
            self.safety.max_late_ticks
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(time_s: f64, state: &'static str) -> Event {
        Event { time_s, state, kind: "", what: String::new() }
    }

    #[test]
    fn only_what_comes_before_a_hold_counts() {
        assert_eq!(before_holds_s(&[], 2.0), 2.0);
        let events = [event(0.5, "active"), event(1.0, "held"), event(1.5, "active")];
        assert_eq!(before_holds_s(&events, 2.0), 1.0);
        // A hold that begins only after the event excuses nothing.
        assert_eq!(before_holds_s(&events, 0.9), 0.9);
    }
}
