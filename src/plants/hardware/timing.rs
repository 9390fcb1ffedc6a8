//! How well the loop keeps time.

/// Lateness of ticks and of commands, seconds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timing {
    /// How much later than planned each tick ended.
    pub jitter_s: Vec<f64>,
    /// From the call of a step to its line on the wire.
    pub latency_s: Vec<f64>,
    /// Ticks that began later than they should have because whoever decides took longer than a tick.
    pub missed: usize,
    /// Ticks during which the robot was held.
    pub held: usize,
}

impl Timing {
    /// The value below which a `share` of `times_s` lies, seconds; 0 when there are none.
    pub fn quantile_s(times_s: &[f64], share: f64) -> f64 {
        let mut sorted = times_s.to_vec();
        sorted.sort_by(f64::total_cmp);
        let index = (share * sorted.len().saturating_sub(1) as f64).round() as usize;
        sorted.get(index).copied().unwrap_or(0.0)
    }
}
