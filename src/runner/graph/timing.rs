//! Wall and processor time of a stage. They reach the manifest and the progress bar, never a
//! result.

use crate::base::{thread_ns, with_time_of_others};
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// What a stage took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// Seconds on the clock.
    pub wall_s: f64,
    /// Seconds on a processor, of all threads that work for the stage; 0 where the system does not
    /// tell.
    pub cpu_s: f64,
}

/// Does `work` and measures it.
pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, Timing) {
    let (began, began_ns) = (Instant::now(), thread_ns());
    let (result, others_ns) = with_time_of_others(work);
    let cpu_ns = thread_ns().saturating_sub(began_ns) + others_ns;
    // 2^53 ns are 104 days.
    (result, Timing { wall_s: began.elapsed().as_secs_f64(), cpu_s: cpu_ns as f64 * 1e-9 })
}
