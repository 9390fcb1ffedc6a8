//! Processor time of this thread.

use std::time::Instant;

/// Runs are timed together until they take this long on the clock: the system counts processor time
/// in ticks.
const BLOCK_S: f64 = 0.12;
/// Timed blocks, the shortest of which counts; a run that takes longer than this is timed twice …
const BLOCKS: usize = 4;
const LONG_S: f64 = 1.0;
/// … and one that takes longer than this once.
const VERY_LONG_S: f64 = 5.0;
/// A run whose mean counts is repeated until this much time has gone by.
const ENOUGH_S: f64 = 0.3;

/// Processor time of this thread from Linux's scheduler statistics (nanoseconds in the first
/// field); `None` where the system does not tell.
fn thread_cpu_s() -> Option<f64> {
    // A thread that offers its turn is counted up to now, not up to the last tick.
    std::thread::yield_now();
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(text.split_whitespace().next()?.parse::<u64>().ok()? as f64 * 1e-9)
}

/// What the times are: processor time, or the wall clock where there is no other.
pub fn kind() -> &'static str {
    if thread_cpu_s().is_some() { "processor time of the thread" } else { "wall clock" }
}

/// Seconds that `run` takes.
fn timed(mut run: impl FnMut()) -> f64 {
    let (began, cpu) = (Instant::now(), thread_cpu_s());
    run();
    let wall = began.elapsed().as_secs_f64();
    thread_cpu_s().zip(cpu).map_or(wall, |(now, before)| now - before)
}

/// The result of `run` and the shortest time that it took: what disturbs a run only ever makes it
/// longer. A run that fails is not repeated.
pub fn best<R, E>(mut run: impl FnMut() -> Result<R, E>) -> (Result<R, E>, f64) {
    let began = Instant::now();
    let mut first = None;
    let spent = timed(|| first = Some(run()));
    let once = began.elapsed().as_secs_f64();
    let mut result = first.unwrap_or_else(&mut run);
    if result.is_err() || once > VERY_LONG_S {
        return (result, spent);
    }
    let each = (BLOCK_S / once.max(1e-9)).ceil().clamp(1.0, 1e6);
    let (blocks, mut shortest) = if once > LONG_S { (1, spent) } else { (BLOCKS, f64::INFINITY) };
    for _ in 0..blocks {
        let spent = timed(|| (0..each as u64).for_each(|_| result = run()));
        shortest = shortest.min(spent / each);
    }
    (result, shortest)
}

/// The last result of `run` and the mean time that it took.
pub fn mean<R>(mut run: impl FnMut() -> R) -> (R, f64) {
    let (mut spent, mut runs) = (0.0, 0.0);
    let mut each = 1_u32;
    loop {
        let mut result = None;
        spent += timed(|| (0..each).for_each(|_| result = Some(run())));
        runs += f64::from(each);
        if let Some(result) = result.filter(|_| spent >= ENOUGH_S) {
            return (result, spent / runs);
        }
        // Ever more between two looks at the time, which take longer than a short run.
        each = each.saturating_mul(2).min((runs * ENOUGH_S / spent.max(1e-9)) as u32).max(1);
    }
}
