//! Frame numbers: new frames, lost frames, and restarts of the server.

/// Duration, s, and number of frames with lower numbers after which the server counts as restarted.
const RESTART_S: f64 = 1.0;
const RESTART_FRAMES: u32 = 5;

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
}

impl FrameSequence {
    /// Accepts lower numbers as a restart at once, after a new handshake.
    pub(crate) fn expect_restart(&mut self) {
        self.restart_expected = true;
    }

    /// Classifies the next frame, received at `now_s`.
    pub(crate) fn classify(&mut self, stamp: FrameStamp, now_s: f64) -> FrameOrder {
        let Some(last) = self.last else {
            self.accept(stamp);
            return FrameOrder::New { lost: 0 };
        };
        let ahead = stamp.ahead(&last);
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
        *self = FrameSequence { last: Some(stamp), refused: None, restart_expected: false };
    }

    /// Single stragglers are old; a consecutive run of frames that are all older than the last one is a restart.
    fn restarted(&mut self, stamp: FrameStamp, now_s: f64) -> bool {
        let Some(run) = &mut self.refused else {
            self.refused = Some(RefusedRun { since_s: now_s, frames: 1, last: stamp });
            return self.restart_expected;
        };
        if stamp.follows(&run.last) {
            run.last = stamp;
            run.frames += 1;
        } else if now_s - run.since_s > RESTART_S {
            *run = RefusedRun { since_s: now_s, frames: 1, last: stamp };
        }
        self.restart_expected || (run.frames >= RESTART_FRAMES && now_s - run.since_s >= RESTART_S)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamp(number: i32) -> FrameStamp {
        FrameStamp { number, stamp_s: f64::from(number) * 0.01 }
    }

    #[test]
    fn numbers_wrap() {
        let mut sequence = FrameSequence::default();
        sequence.classify(FrameStamp { number: i32::MAX, stamp_s: 1.0 }, 0.0);
        assert_eq!(
            sequence.classify(FrameStamp { number: i32::MIN + 1, stamp_s: 1.02 }, 0.02),
            FrameOrder::New { lost: 1 }
        );
    }

    #[test]
    fn a_straggler_is_old_and_a_second_of_them_a_restart() {
        let mut sequence = FrameSequence::default();
        sequence.classify(stamp(1000), 0.0);
        let orders: Vec<FrameOrder> = (1..150).map(|k| sequence.classify(stamp(k), f64::from(k) * 0.01)).collect();
        let restart = orders.iter().position(|order| *order == FrameOrder::Restart);
        assert!(restart.is_some_and(|at| (99..=102).contains(&at)), "{restart:?}");
        assert!(orders[..99].iter().all(|order| *order == FrameOrder::Old));
        assert_eq!(orders[110], FrameOrder::New { lost: 0 });
    }

    #[test]
    fn a_clock_that_stands_is_no_restart() {
        let mut sequence = FrameSequence::default();
        sequence.classify(FrameStamp { number: 1, stamp_s: 5.0 }, 0.0);
        for k in 2..500 {
            assert_eq!(
                sequence.classify(FrameStamp { number: k, stamp_s: 5.0 }, f64::from(k) * 0.01),
                FrameOrder::StuckClock
            );
        }
        assert_eq!(sequence.classify(FrameStamp { number: 500, stamp_s: 9.0 }, 5.0), FrameOrder::New { lost: 498 });
    }
}
