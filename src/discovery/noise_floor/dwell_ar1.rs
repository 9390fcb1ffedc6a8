//! AR(1) noise from dwells: consecutive samples of a robot at rest, each dwell with its own mean.

use crate::discovery::recording::samples::Samples;

/// Number of samples, beyond two a dwell, that determine a correlation.
const MIN_SAMPLES: usize = 50;
/// Dwells contradict a correlation that differs by more than this many standard deviations.
const CONTRADICTION_SIGMA: f64 = 6.0;
/// Correlations above this cannot be told from drift.
const MAX_CORRELATION: f64 = 0.98;
/// Step of the numerical derivative with respect to the correlation.
const DIFFERENCE: f64 = 1e-4;
/// Bisection steps for the correlation.
const BISECTIONS: usize = 30;

/// Moments of a sum of squares about group means, in units of the noise variance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SquareSumMoments {
    /// Expected value.
    pub(crate) mean: f64,
    /// Half the variance.
    half_variance: f64,
}

impl SquareSumMoments {
    /// Moments for groups of these sizes with correlated neighbours, including the uncertainty of
    /// the correlation itself (to first order).
    pub(crate) fn of(
        counts: impl Iterator<Item = usize> + Clone,
        correlation: f64,
    ) -> SquareSumMoments {
        let sums = |correlation: f64| {
            let each = counts.clone().map(|count| moments(count, correlation));
            each.fold([0.0, 0.0], |sum, moments| [sum[0] + moments[0], sum[1] + moments[1]])
        };
        let [mean, half_variance] = sums(correlation);
        if correlation == 0.0 {
            return SquareSumMoments { mean, half_variance };
        }
        let slope = (sums(correlation)[0] - sums(correlation - DIFFERENCE)[0]) / DIFFERENCE;
        let samples = counts.map(beyond_two).sum::<usize>().max(1) as f64;
        // Variance of an estimated correlation on one axis: Quenouille, Journal of the Royal
        // Statistical Society 110, 1947.
        let unknown = slope * slope * (1.0 - correlation * correlation) / samples;
        SquareSumMoments { mean, half_variance: half_variance + 0.5 * unknown }
    }

    /// Moments of the sum of both.
    pub(crate) fn combined_with(self, other: SquareSumMoments) -> SquareSumMoments {
        SquareSumMoments {
            mean: self.mean + other.mean,
            half_variance: self.half_variance + other.half_variance,
        }
    }

    /// Degrees of freedom of a scaled χ² with this mean and variance (Box, Annals of Mathematical
    /// Statistics 25, 1954).
    pub(crate) fn freedom(&self) -> f64 {
        if self.half_variance > 0.0 { self.mean * self.mean / self.half_variance } else { 0.0 }
    }
}

/// Mean and half the variance of the sum of squares about the mean of `count` samples of unit
/// variance.
fn moments(count: usize, correlation: f64) -> [f64; 2] {
    let n = count as f64;
    let powers: Vec<f64> = (0..count).map(|lag| correlation.powf(lag as f64)).collect();
    // Cumulative sums of the powers.
    let mut sums = powers.clone();
    (1..count).for_each(|k| sums[k] += sums[k - 1]);
    // Row sums of the correlation matrix of one group.
    let rows: Vec<f64> = (0..count).map(|k| sums[k] + sums[count - 1 - k] - 1.0).collect();
    let all: f64 = rows.iter().sum();
    // Σ ρᵢⱼ²: each lag occurs twice in the matrix, but for the diagonal.
    let square =
        |lag: usize| if lag == 0 { n } else { 2.0 * (n - lag as f64) * powers[lag].powi(2) };
    let squares: f64 = (0..count).map(square).sum();
    // tr((C R)²) with the centring matrix C, half the variance of a Gaussian quadratic form.
    let half_variance =
        squares - 2.0 / n * rows.iter().map(|row| row * row).sum::<f64>() + (all / n).powi(2);
    [n - all / n, half_variance]
}

fn beyond_two(count: usize) -> usize {
    count.saturating_sub(2)
}

/// Sums of squares about the mean along each axis, m².
pub(crate) fn squares_m2(samples: &Samples, group: &[usize]) -> [f64; 3] {
    std::array::from_fn(|axis| {
        let values: Vec<f64> =
            group.iter().map(|&row| samples.rows[row].position_m[axis]).collect();
        let mean = crate::math::summary::mean(&values);
        values.iter().map(|value| (value - mean).powi(2)).sum()
    })
}

/// Correlation of consecutive samples: `believed`, unless the `dwells` contradict it by the ratio
/// of successive differences to the variance (von Neumann, Annals of Mathematical Statistics 12,
/// 1941). Model errors are correlated, too.
pub(crate) fn correlation(samples: &Samples, dwells: &[&[usize]], believed: f64) -> f64 {
    let count: usize = dwells.iter().map(|dwell| beyond_two(dwell.len())).sum();
    if count < MIN_SAMPLES {
        return believed;
    }
    let measured = measured_correlation(samples, dwells);
    let deviation = ((1.0 - believed * believed) / count as f64).sqrt();
    if (measured - believed).abs() < CONTRADICTION_SIGMA * deviation { believed } else { measured }
}

/// The correlation that the ratio of successive differences to the variance shows, by bisection of
/// its expectation.
fn measured_correlation(samples: &Samples, dwells: &[&[usize]]) -> f64 {
    let half_m2 = |dwell: &[usize], axis: usize| -> f64 {
        let at = |row: usize| samples.rows[row].position_m[axis];
        dwell.windows(2).map(|pair| 0.5 * (at(pair[1]) - at(pair[0])).powi(2)).sum()
    };
    let ratio = |axis: usize| -> f64 {
        let near: f64 = dwells.iter().map(|dwell| half_m2(dwell, axis)).sum();
        let all: f64 = dwells.iter().map(|dwell| squares_m2(samples, dwell)[axis]).sum();
        if all > 0.0 { near / all } else { 1.0 }
    };
    let measured = (0..3).map(ratio).sum::<f64>() / 3.0;
    let neighbours: usize = dwells.iter().map(|dwell| dwell.len() - 1).sum();
    let expected = |correlation: f64| {
        let all: f64 = dwells.iter().map(|dwell| moments(dwell.len(), correlation)[0]).sum();
        (1.0 - correlation) * neighbours as f64 / all
    };
    let (mut low, mut high) = (0.0, MAX_CORRELATION);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        // The expected ratio falls as the correlation grows.
        *(if expected(middle) > measured { &mut low } else { &mut high }) = middle;
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_samples_are_worth_one_less_than_there_are() {
        for count in [2, 3, 20] {
            let [own, half_variance] = moments(count, 0.0);
            assert!(
                (own - (count as f64 - 1.0)).abs() < 1e-12 && (half_variance - own).abs() < 1e-9,
                "{count}: {own} {half_variance}"
            );
        }
        // Two correlated samples differ by the uncorrelated part only.
        let [own, half_variance] = moments(2, 0.6);
        assert!((own - 0.4).abs() < 1e-12 && (half_variance - 0.16).abs() < 1e-12);
    }
}
