//! Time as the drivers see it: the wall clock with a real robot, a clock of its own in rehearsals.

use std::time::Duration;

/// Seconds since an arbitrary instant, and a way to wait for a later one.
pub trait Clock: Send + Sync {
    /// Seconds since the clock was created; never decreases.
    fn now_s(&self) -> f64;
    /// Returns once `now_s` is at least `time_s`.
    fn sleep_until(&self, time_s: f64);
    /// Registers the calling thread as one that waits on this clock. A clock that makes its own
    /// time does not advance while a registered thread runs.
    fn join(&self) {}
    /// The opposite of [`Clock::join`].
    fn leave(&self) {}
    /// True for a clock that advances on its own, whether or not any thread waits on it.
    fn is_real(&self) -> bool {
        false
    }
}

/// The computer's monotonic clock. On Linux it also counts the time during which the computer is
/// suspended: the robot and its tracker go on meanwhile.
#[derive(Clone, Copy, Debug)]
pub struct WallClock {
    start: Duration,
}

impl WallClock {
    /// A clock that reads 0 now.
    pub fn new() -> WallClock {
        WallClock { start: monotonic() }
    }
}

#[cfg(target_os = "linux")]
fn monotonic() -> Duration {
    use nix::time::{ClockId, clock_gettime};
    // Linux 2.6.39 and later have this clock, and it cannot fail.
    clock_gettime(ClockId::CLOCK_BOOTTIME).map_or(Duration::ZERO, Duration::from)
}

#[cfg(not(target_os = "linux"))]
fn monotonic() -> Duration {
    use std::sync::OnceLock;
    use std::time::Instant;
    static FIRST: OnceLock<Instant> = OnceLock::new();
    FIRST.get_or_init(Instant::now).elapsed()
}

impl Default for WallClock {
    fn default() -> Self {
        WallClock::new()
    }
}

impl Clock for WallClock {
    fn is_real(&self) -> bool {
        true
    }

    fn now_s(&self) -> f64 {
        monotonic().saturating_sub(self.start).as_secs_f64()
    }

    fn sleep_until(&self, time_s: f64) {
        let wait_s = time_s - self.now_s();
        if wait_s > 0.0 {
            std::thread::sleep(Duration::from_secs_f64(wait_s));
        }
    }
}
