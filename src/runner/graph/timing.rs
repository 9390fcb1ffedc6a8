//! Wall and processor time of a stage. They reach the manifest and the progress bar, never a
//! result.

use serde::{Deserialize, Serialize};
use std::time::Instant;

/// What a stage took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// Seconds on the clock.
    pub wall_s: f64,
    /// Seconds on a processor, of the thread that carries the stage out and not of those that it
    /// shares its work with; 0 where the system does not tell.
    pub cpu_s: f64,
}

/// A stopwatch for the current thread.
pub(crate) struct Stopwatch {
    began: Instant,
    cpu_s: f64,
}

impl Stopwatch {
    /// Starts.
    pub(crate) fn start() -> Stopwatch {
        Stopwatch { began: Instant::now(), cpu_s: thread_cpu_s() }
    }

    /// Time since the start, on the same thread.
    pub(crate) fn read(&self) -> Timing {
        Timing { wall_s: self.began.elapsed().as_secs_f64(), cpu_s: thread_cpu_s() - self.cpu_s }
    }
}

/// Processor time of this thread in seconds, from Linux's scheduler statistics (nanoseconds in the
/// first field).
#[allow(clippy::cast_precision_loss)] // 2^53 ns are 104 days
fn thread_cpu_s() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split_whitespace().next().and_then(|field| field.parse::<u64>().ok()).unwrap_or(0) as f64
        * 1e-9
}
