//! Offset between the server's clock and the local clock.
//!
//! A frame arrives at its stamp, plus the clock offset, plus a non-negative delay. The minimum of
//! many "received − stamp" is therefore the offset plus the smallest delay. A delay that begins and
//! persists makes samples old for as long as an earlier, smaller one is remembered; after that it
//! cannot be distinguished from the offset.

use std::collections::VecDeque;

/// The minimum is taken over this many intervals of this length, s: long compared with bursts of
/// delay, short enough that two quartz clocks drift apart by less than a millisecond.
const INTERVALS: usize = 10;
const INTERVAL_S: f64 = 1.0;

/// Weight of the newest delay in the running mean.
const NEWEST_WEIGHT: f64 = 1.0 / 32.0;

/// Estimate of the clock offset.
#[derive(Clone, Debug, Default)]
pub(crate) struct ClockSync {
    /// Start of each interval and its minimum, s.
    intervals: VecDeque<(f64, f64)>,
    jitter_s: f64,
}

impl ClockSync {
    /// Adds a frame stamped `stamp_s` that was received at `received_s`. Returns the clock offset,
    /// s.
    pub(crate) fn update(&mut self, stamp_s: f64, received_s: f64) -> f64 {
        let difference_s = received_s - stamp_s;
        match self.intervals.back_mut() {
            Some((start_s, min_s)) if received_s - *start_s < INTERVAL_S => {
                *min_s = min_s.min(difference_s)
            }
            _ => self.intervals.push_back((received_s, difference_s)),
        }
        // Old minima are forgotten, because quartz clocks drift.
        let oldest_s = received_s - INTERVALS as f64 * INTERVAL_S;
        self.intervals.retain(|(start_s, _)| *start_s > oldest_s);
        let offset_s =
            self.intervals.iter().fold(difference_s, |min, interval| min.min(interval.1));
        self.jitter_s += NEWEST_WEIGHT * (difference_s - offset_s - self.jitter_s);
        offset_s
    }

    /// The greatest stamp that a frame received at `now_s` can have, s; infinite before the first
    /// frame.
    pub(crate) fn present_stamp_s(&self, now_s: f64) -> f64 {
        let min = self.intervals.iter().map(|interval| interval.1).reduce(f64::min);
        min.map_or(f64::INFINITY, |offset_s| now_s - offset_s)
    }

    /// Mean delay of the frames beyond the smallest one, s.
    pub(crate) fn jitter_s(&self) -> f64 {
        self.jitter_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_do_not_move_the_clock() {
        let mut map = ClockSync::default();
        let mut offset_s = 0.0;
        for k in 0..3000 {
            let time_s = f64::from(k) * 0.01;
            let delay_s = f64::from(k * 7919 % 13) * 0.004;
            offset_s = map.update(time_s + 1e6, time_s + 0.003 + delay_s);
        }
        assert!((offset_s + 1e6 - 0.003).abs() < 1e-9, "{offset_s}");
        assert!((map.jitter_s() - 0.024).abs() < 0.01);
        assert!(map.intervals.len() <= INTERVALS);
    }
}
