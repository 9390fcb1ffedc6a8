//! Timing of the control loop.

/// The shortest time that is distinguished from 0, s.
const MIN_S: f64 = 1e-6;
/// Bins per decade: neighbours differ by 2.3 %.
const BINS_PER_DECADE: usize = 100;
/// Bins from a microsecond to a hundred seconds; longer times fall into the last one.
const BINS: usize = 8 * BINS_PER_DECADE + 1;

/// Distribution of delays: number, maximum, and a histogram of constant size.
#[derive(Clone, Debug, PartialEq)]
pub struct Lateness {
    count: u64,
    most_s: f64,
    /// Counts in each bin of [`bin`].
    bins: Vec<u64>,
}

impl Default for Lateness {
    fn default() -> Self {
        Lateness { count: 0, most_s: 0.0, bins: vec![0; BINS] }
    }
}

impl Lateness {
    /// Adds a time, s; negative ones count as 0.
    pub fn push(&mut self, time_s: f64) {
        self.count += 1;
        self.most_s = self.most_s.max(time_s);
        self.bins[bin(time_s)] += 1;
    }

    /// Number of times.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The longest time, s; 0 if there are none.
    pub fn most_s(&self) -> f64 {
        self.most_s
    }

    /// Quantile `share` of the times, s: at most 2.3 % above the exact one, never below it; 0 if
    /// there are none.
    pub fn quantile_s(&self, share: f64) -> f64 {
        let rank = (share * self.count as f64).ceil();
        let mut below = 0;
        for (bin, number) in self.bins.iter().enumerate() {
            below += number;
            if *number > 0 && below as f64 >= rank {
                return upper_s(bin).min(self.most_s);
            }
        }
        self.most_s
    }
}

fn bin(time_s: f64) -> usize {
    if time_s <= MIN_S {
        return 0;
    }
    let decades = (time_s / MIN_S).log10();
    ((decades * BINS_PER_DECADE as f64).floor() as usize + 1).min(BINS - 1)
}

fn upper_s(bin: usize) -> f64 {
    if bin + 1 == BINS {
        f64::INFINITY
    } else {
        MIN_S * 10_f64.powf(bin as f64 / BINS_PER_DECADE as f64)
    }
}

/// Delays of ticks and of commands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoopTiming {
    /// Delay of the end of each tick.
    pub jitter: Lateness,
    /// Time from the call of a step until its line is sent; for a command of several ticks, from
    /// the start of each.
    pub latency: Lateness,
    /// Ticks that began late because the policy took longer than a tick.
    pub missed: usize,
    /// Ticks during which the robot was held.
    pub held: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_never_flattered_and_close() {
        let mut lateness = Lateness::default();
        assert_eq!((lateness.quantile_s(0.99), lateness.most_s()), (0.0, 0.0));
        (1..=1000).for_each(|k| lateness.push(1e-5 * f64::from(k)));
        for share in [0.01, 0.5, 0.9, 0.99] {
            let (found_s, exact_s) = (lateness.quantile_s(share), share * 1e-2);
            assert!(
                found_s >= exact_s && found_s <= 1.024 * exact_s,
                "{share}: {found_s} s, {exact_s} s"
            );
        }
        assert_eq!((lateness.count(), lateness.quantile_s(1.0)), (1000, 0.01));
        for odd_s in [-1.0, 0.0, f64::NAN, 1e9] {
            lateness.push(odd_s);
        }
        assert_eq!((lateness.count(), lateness.most_s()), (1004, 1e9));
        assert_eq!(lateness.quantile_s(1.0), 1e9);
    }
}
