//! Shares and medians with intervals.

use crate::math::summary::quantile;

/// Standard normal quantile at 97.5 %.
const Z: f64 = 1.959_963_984_540_054;

/// A number with its 95 % interval; the ends are not numbers where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct IntervalEstimate {
    pub(crate) value: f64,
    pub(crate) low_95: f64,
    pub(crate) high_95: f64,
}

/// The share `hits / of` with its interval (Wilson 1927): right near 0 and 1, and for few cases.
/// Nothing of no cases.
pub(crate) fn wilson(hits: u64, of: u64) -> Option<IntervalEstimate> {
    if hits > of { None } else { wilson_mean(hits as f64, of) }
}

/// The same for the mean of numbers between 0 and 1 with this `sum`: none varies more than hits and
/// misses with the same mean, so that the interval is wide enough. Nothing of no numbers.
pub(crate) fn wilson_mean(sum: f64, of: u64) -> Option<IntervalEstimate> {
    if of == 0 {
        return None;
    }
    let (n, value) = (of as f64, sum / of as f64);
    let spread = Z * Z / n;
    let centre = (value + 0.5 * spread) / (1.0 + spread);
    let half = Z * (value * (1.0 - value) / n + 0.25 * spread / n).sqrt() / (1.0 + spread);
    // At the ends the formula gives 0 and 1 but for rounding.
    let low_95 = if value <= 0.0 { 0.0 } else { centre - half };
    let high_95 = if value >= 1.0 { 1.0 } else { centre + half };
    Some(IntervalEstimate { value, low_95, high_95 })
}

/// The median with its interval between order statistics (Conover 1999, section 3.2); nothing of no
/// values, and no interval of fewer than six, whose ends would lie beyond the sample.
pub(crate) fn median(values: &[f64]) -> Option<IntervalEstimate> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    if sorted.is_empty() {
        return None;
    }
    let n = sorted.len() as f64;
    let half_width = 0.5 * Z * n.sqrt();
    let low = (0.5 * n - half_width).floor() as isize - 1;
    let high = (0.5 * n + half_width).ceil() as usize;
    let ends = match usize::try_from(low) {
        Ok(low) if high < sorted.len() => [sorted[low], sorted[high]],
        _ if sorted.len() >= 6 => [sorted[0], sorted[sorted.len() - 1]],
        _ => [f64::NAN; 2],
    };
    Some(IntervalEstimate { value: quantile(&sorted, 0.5), low_95: ends[0], high_95: ends[1] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wilsons_interval_is_the_textbooks() {
        // Newcombe 1998, Statistics in Medicine 17, table I: 81 of 263, 15 of 148, 0 of 20, 1 of
        // 29, method 3.
        for (hits, of, low, high) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ] {
            let found = wilson(hits, of).unwrap();
            assert!(
                (found.low_95 - low).abs() < 5e-5 && (found.high_95 - high).abs() < 5e-5,
                "{hits}: {found:?}"
            );
        }
        assert_eq!(wilson(0, 0), None);
        assert_eq!(wilson(7, 7).unwrap().high_95, 1.0);
    }

    #[test]
    fn the_medians_interval_holds_it_as_often_as_it_says() {
        // The exact binomial probability that the median of n draws lies between the two order
        // statistics.
        for n in [6usize, 9, 20, 100, 297] {
            let values: Vec<f64> = (0..n).map(|value| value as f64).collect();
            let found = median(&values).unwrap();
            let (low, high) = (found.low_95 as usize + 1, found.high_95 as usize + 1);
            let mut term = 0.5f64.powi(n as i32);
            let mut inside = 0.0;
            for k in 0..=n {
                if (low..high).contains(&k) {
                    inside += term;
                }
                term *= (n - k) as f64 / (k + 1) as f64;
            }
            assert!(inside > 0.945, "{n}: {inside}");
        }
        assert!(median(&[1.0, 2.0]).unwrap().low_95.is_nan());
        assert_eq!(median(&[f64::NAN, 3.0]).unwrap().value, 3.0);
        assert_eq!(median(&[f64::NAN]), None);
    }
}
