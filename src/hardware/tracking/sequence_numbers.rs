//! Frame numbers and time stamps: new frames, lost frames, restarts of the server, and frames of
//! another source.
//!
//! A second server on the same computer and port can only be told by its count and its clock: one
//! frame cannot be seconds ahead of the server's clock, count hundreds of frames within one period,
//! or alternate with frames that are seconds newer.

/// Duration, s, and number of frames with lower numbers after which the server counts as restarted.
const MIN_RESTART_S: f64 = 1.0;
const MIN_RESTART_FRAMES: u32 = 5;

/// Difference of clocks or counts, s, above which a frame is of another source: far more than
/// delays and gaps are.
const MIN_JUMP_S: f64 = 1.0;
/// Ratio of the true frame rate to the configured one that is not taken for a jump.
const MAX_RATE_RATIO: f64 = 5.0;
/// Frames from long before that alternate with new ones, after which they count as another
/// source's.
const MAX_ALTERNATING: u32 = 2;
/// The same of frames that are at least this old, s, but not from long before: these must be in
/// order among themselves, which delayed frames of one server are not.
const MIN_BEHIND_S: f64 = 0.1;
const MAX_ALTERNATING_IN_ORDER: u32 = 10;

/// Number and time stamp of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrameStamp {
    /// The server's frame number; wraps.
    pub(crate) number: i32,
    /// The server's clock, s.
    pub(crate) stamp_s: f64,
}

impl FrameStamp {
    /// Frames from `earlier` to this one; negative for an older frame.
    fn ahead(&self, earlier: &FrameStamp) -> i32 {
        // Wrapping: a counter that overflows has not restarted.
        self.number.wrapping_sub(earlier.number)
    }

    fn follows(&self, earlier: &FrameStamp) -> bool {
        self.ahead(earlier) > 0 && self.stamp_s > earlier.stamp_s
    }
}

/// Order of a frame relative to the last new one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FrameOrder {
    /// New, after `lost` missing frames.
    New { lost: u64 },
    /// The same frame again.
    Duplicate,
    /// Older than the last new frame.
    Old,
    /// A higher number, but the server's clock has not advanced.
    StuckClock,
    /// New, after a restart of the server.
    Restart,
    /// Of another source than the frames before: its count or its clock is far from theirs.
    Foreign,
}

/// Rejected frames that follow each other.
#[derive(Clone, Copy, Debug)]
struct RefusedRun {
    since_s: f64,
    frames: u32,
    last: FrameStamp,
}

/// State of the sequence so far.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FrameSequence {
    last: Option<FrameStamp>,
    refused: Option<RefusedRun>,
    restart_expected: bool,
    /// Configured frame rate, Hz; 0 if counts are not compared with stamps.
    rate_hz: f64,
    /// Old frames that came after newer ones, the last one, and when it did, s.
    alternating: u32,
    behind: Option<(FrameStamp, f64)>,
}

impl FrameSequence {
    /// The sequence of a tracker with this frame rate.
    pub(crate) fn new(rate_hz: f64) -> FrameSequence {
        FrameSequence { rate_hz, ..FrameSequence::default() }
    }

    /// Accepts lower numbers as a restart at once, after a new handshake.
    pub(crate) fn expect_restart(&mut self) {
        self.restart_expected = true;
    }

    /// Classifies the next frame, received at `now_s`, when the server's clock reads `present_s` at
    /// most (infinite if that is not known yet).
    pub(crate) fn classify(&mut self, stamp: FrameStamp, now_s: f64, present_s: f64) -> FrameOrder {
        let Some(last) = self.last else {
            self.accept(stamp);
            return FrameOrder::New { lost: 0 };
        };
        let ahead = stamp.ahead(&last);
        if !self.restart_expected
            && (self.jumps_ahead(&stamp, &last, present_s) || self.alternates(&stamp, &last, now_s))
        {
            return FrameOrder::Foreign;
        }
        if stamp.follows(&last) {
            self.accept(stamp);
            return FrameOrder::New { lost: u64::from(ahead.unsigned_abs()) - 1 };
        }
        if ahead == 0 {
            return FrameOrder::Duplicate;
        }
        if self.restarted(stamp, now_s) {
            self.accept(stamp);
            return FrameOrder::Restart;
        }
        if ahead > 0 { FrameOrder::StuckClock } else { FrameOrder::Old }
    }

    fn accept(&mut self, stamp: FrameStamp) {
        (self.last, self.refused, self.restart_expected) = (Some(stamp), None, false);
    }

    /// A frame from the future, or a count that does not go with the clock.
    fn jumps_ahead(&self, stamp: &FrameStamp, last: &FrameStamp, present_s: f64) -> bool {
        let passed_s = stamp.stamp_s - last.stamp_s;
        let ahead = f64::from(stamp.ahead(last));
        let counted_s = if self.rate_hz > 0.0 { ahead / self.rate_hz } else { passed_s };
        let miscounted =
            ahead > 0.0 && passed_s > 0.0 && counted_s > MIN_JUMP_S + MAX_RATE_RATIO * passed_s;
        stamp.stamp_s - present_s > MIN_JUMP_S || miscounted
    }

    /// An old frame, although newer ones have come since the last such frame.
    fn alternates(&mut self, stamp: &FrameStamp, last: &FrameStamp, now_s: f64) -> bool {
        let age_s = last.stamp_s - stamp.stamp_s;
        // Small delays happen on every network; a run of old frames is a restart.
        if age_s <= MIN_BEHIND_S || self.refused.is_some() {
            return false;
        }
        let long_before = age_s > MIN_JUMP_S;
        let before =
            self.behind.replace((*stamp, now_s)).filter(|(_, then_s)| now_s - then_s <= MIN_JUMP_S);
        let continues = before.is_some_and(|(before, _)| long_before || stamp.follows(&before));
        self.alternating = if continues { self.alternating + 1 } else { 1 };
        self.alternating > if long_before { MAX_ALTERNATING } else { MAX_ALTERNATING_IN_ORDER }
    }

    /// Single stragglers are old; a consecutive run of frames that are all older than the last one
    /// is a restart.
    fn restarted(&mut self, stamp: FrameStamp, now_s: f64) -> bool {
        let Some(run) = &mut self.refused else {
            self.refused = Some(RefusedRun { since_s: now_s, frames: 1, last: stamp });
            return self.restart_expected;
        };
        if stamp.follows(&run.last) {
            run.last = stamp;
            run.frames += 1;
        } else if now_s - run.since_s > MIN_RESTART_S {
            *run = RefusedRun { since_s: now_s, frames: 1, last: stamp };
        }
        self.restart_expected
            || (run.frames >= MIN_RESTART_FRAMES && now_s - run.since_s >= MIN_RESTART_S)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The server's clock is not known.
    const NOW: f64 = f64::INFINITY;

    fn at(number: i32, stamp_s: f64) -> FrameStamp {
        FrameStamp { number, stamp_s }
    }

    fn stamp(number: i32) -> FrameStamp {
        at(number, f64::from(number) * 0.01)
    }

    #[test]
    fn numbers_wrap() {
        let mut sequence = FrameSequence::default();
        sequence.classify(at(i32::MAX, 1.0), 0.0, NOW);
        assert_eq!(
            sequence.classify(at(i32::MIN + 1, 1.02), 0.02, NOW),
            FrameOrder::New { lost: 1 }
        );
    }

    #[test]
    fn a_straggler_is_old_and_a_second_of_them_a_restart() {
        let mut sequence = FrameSequence::default();
        sequence.classify(stamp(1000), 0.0, NOW);
        let orders: Vec<FrameOrder> =
            (1..150).map(|k| sequence.classify(stamp(k), f64::from(k) * 0.01, NOW)).collect();
        let restart = orders.iter().position(|order| *order == FrameOrder::Restart);
        assert!(restart.is_some_and(|at| (99..=102).contains(&at)), "{restart:?}");
        assert!(orders[..99].iter().all(|order| *order == FrameOrder::Old));
        assert_eq!(orders[110], FrameOrder::New { lost: 0 });
    }

    #[test]
    fn a_clock_that_stands_is_no_restart() {
        let mut sequence = FrameSequence::default();
        sequence.classify(at(1, 5.0), 0.0, NOW);
        for k in 2..500 {
            assert_eq!(
                sequence.classify(at(k, 5.0), f64::from(k) * 0.01, NOW),
                FrameOrder::StuckClock
            );
        }
        assert_eq!(sequence.classify(at(500, 9.0), 5.0, NOW), FrameOrder::New { lost: 498 });
    }

    /// Two servers at one address, 77,777 frames and 500 s apart, as they were seen.
    #[test]
    fn a_jump_of_the_count_or_of_the_clock_is_another_source() {
        let begun = || {
            let mut sequence = FrameSequence::new(100.0);
            (1..=10).for_each(|k| {
                assert_eq!(
                    sequence.classify(stamp(k), 0.01 * f64::from(k), 0.01 * f64::from(k)),
                    FrameOrder::New { lost: 0 }
                );
            });
            sequence
        };
        let mut both = begun();
        for k in 11..=40 {
            let now_s = 0.01 * f64::from(k);
            let other = at(k + 77_777, now_s + 500.0);
            assert_eq!(both.classify(other, now_s, now_s), FrameOrder::Foreign);
            assert_eq!(both.classify(stamp(k), now_s, now_s), FrameOrder::New { lost: 0 });
        }
        let number_only = at(77_777, 0.11);
        assert_eq!(begun().classify(number_only, 0.11, 0.11), FrameOrder::Foreign);
        // The other one is behind: while both stream, it is found out.
        let mut behind = FrameSequence::new(100.0);
        let orders: Vec<FrameOrder> = (1..=20)
            .flat_map(|k| {
                let now_s = 0.01 * f64::from(k);
                let ahead = at(k + 77_777, now_s + 500.0);
                [behind.classify(ahead, now_s, NOW), behind.classify(stamp(k), now_s, NOW)]
            })
            .collect();
        assert_eq!(
            orders.iter().filter(|order| **order == FrameOrder::Foreign).count(),
            18,
            "{orders:?}"
        );
    }

    /// Two servers whose clocks agree within half a second: the frames of the one behind are old,
    /// and in order.
    #[test]
    fn a_source_a_little_behind_is_told_from_delayed_frames() {
        let mut sequence = FrameSequence::new(100.0);
        let mut foreign = |k: i32, ahead: i32, now_s: f64| {
            let number = k + ahead;
            let stamp = FrameStamp { number, stamp_s: 0.01 * f64::from(number) };
            sequence.classify(stamp, now_s, now_s + 0.5) == FrameOrder::Foreign
        };
        let found = (1..=30).filter(|&k| {
            let now_s = 0.01 * f64::from(k);
            foreign(k, 40, now_s) | foreign(k, 0, now_s)
        });
        assert_eq!(found.count(), 20);
        // One server, every second frame of which takes from 0 to 0.4 s longer, each its own time.
        let mut sequence = FrameSequence::new(100.0);
        let mut arrivals: Vec<(i32, i32)> =
            (1..=400).map(|k| (k + k % 2 * (k * 37 % 41), k)).collect();
        arrivals.sort_unstable();
        for (arrived, number) in arrivals {
            let stamp = FrameStamp { number, stamp_s: 0.01 * f64::from(number) };
            let now_s = 0.01 * f64::from(arrived);
            assert_ne!(sequence.classify(stamp, now_s, now_s), FrameOrder::Foreign, "{number}");
        }
    }

    #[test]
    fn gaps_bursts_and_other_rates_are_no_other_source() {
        let mut sequence = FrameSequence::new(100.0);
        let mut now_s = 0.0;
        for (number, stamp_s, delay_s) in
            [(1, 0.01, 0.3), (2, 0.02, 0.0), (300, 3.0, 0.2), (301, 3.01, 0.0), (541, 4.01, 0.0)]
        {
            now_s = f64::max(now_s, stamp_s + delay_s);
            let order = sequence.classify(at(number, stamp_s), now_s, now_s);
            assert!(matches!(order, FrameOrder::New { .. }), "{number}: {order:?}");
        }
        // After a new handshake a server may count from anywhere.
        sequence.expect_restart();
        let order = sequence.classify(at(900_000, 1e6), 5.0, 5.0);
        assert!(matches!(order, FrameOrder::New { .. }), "{order:?}");
    }
}
