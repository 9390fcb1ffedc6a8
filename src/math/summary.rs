//! Sample statistics: mean, standard deviation, quantile, interval of a mean, oscillation.

use super::distribution::student_95;

/// Arithmetic mean; not a number for no values.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Sample standard deviation (divisor n − 1); not a number for fewer than two values.
pub fn standard_deviation(values: &[f64]) -> f64 {
    let centre = mean(values);
    let squares: f64 = values.iter().map(|value| (value - centre).powi(2)).sum();
    if values.len() < 2 { f64::NAN } else { (squares / (values.len() - 1) as f64).sqrt() }
}

/// Root of the mean square; not a number for no values.
pub fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}

/// Quantile `share` (0 to 1) with linear interpolation between order statistics (Hyndman & Fan
/// 1996, definition 7); not a number for no values.
pub fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let place = share.clamp(0.0, 1.0) * last as f64;
    let low = place.floor() as usize;
    let high = place.ceil() as usize;
    sorted[low] + (place - low as f64) * (sorted[high] - sorted[low])
}

/// 95 % interval of the mean of independent `values`, Student's t; `None` for fewer than two.
pub fn interval_95(values: &[f64]) -> Option<[f64; 2]> {
    let freedom = values.len().checked_sub(1).filter(|&freedom| freedom > 0)? as f64;
    let half = student_95(freedom) * standard_deviation(values) / (values.len() as f64).sqrt();
    let centre = mean(values);
    half.is_finite().then_some([centre - half, centre + half])
}

/// Rank correlation (Spearman 1904), ties with their mean rank; not a number for fewer than three
/// pairs or equal values.
pub fn rank_correlation(first: &[f64], second: &[f64]) -> f64 {
    if first.len() < 3 {
        return f64::NAN;
    }
    let (a, b) = (ranks(first), ranks(second));
    let (centre_a, centre_b) = (mean(&a), mean(&b));
    let covariance: f64 = a.iter().zip(&b).map(|(x, y)| (x - centre_a) * (y - centre_b)).sum();
    covariance / (standard_deviation(&a) * standard_deviation(&b) * (a.len() - 1) as f64)
}

fn ranks(values: &[f64]) -> Vec<f64> {
    let below = |value: f64| values.iter().filter(|other| **other < value).count() as f64;
    let equal = |value: f64| values.iter().filter(|other| **other == value).count() as f64;
    values.iter().map(|&value| below(value) + 0.5 * (equal(value) + 1.0)).collect()
}

/// Oscillation of a series: the median peak-to-peak over all half-overlapping windows, after
/// subtracting a centred moving mean over `window` values. A slow drift does not count, a single
/// jump affects few windows. A sine of amplitude a counts 2a when the window holds whole periods
/// (within 22 % when it holds at least one and a half: the response of the moving mean, sin(πk)/πk
/// for k periods). 0 for a series shorter than two windows.
pub fn oscillation(values: &[f64], window: usize) -> f64 {
    let half = window.max(3) / 2;
    let window = 2 * half + 1;
    if values.len() < 2 * window {
        return 0.0;
    }
    let centres = values.windows(window).map(mean);
    let deviations: Vec<f64> =
        values[half..].iter().zip(centres).map(|(value, centre)| value - centre).collect();
    let swings: Vec<f64> = (0..=deviations.len() - window)
        .step_by(half)
        .map(|start| swing(&deviations[start..][..window]))
        .collect();
    quantile(&swings, 0.5)
}

/// Peak-to-peak.
fn swing(values: &[f64]) -> f64 {
    let (low, high) = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)));
    high - low
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the formula of distinct ranks: 1 − 6 Σd²/(n(n² − 1)) with d = 0, 1, −1, 0 and n = 4 is
    /// 0.8.
    #[test]
    fn rank_correlation_is_that_of_the_formula() {
        assert!(
            (rank_correlation(&[1.0, 2.0, 3.0, 9.0], &[0.1, 0.7, 0.3, 0.8]) - 0.8).abs() < 1e-12
        );
        assert!(
            (rank_correlation(&[1.0, 2.0, 2.0, 3.0], &[5.0, 6.0, 6.0, 7.0]) - 1.0).abs() < 1e-12
        );
        assert!(rank_correlation(&[1.0, 2.0], &[1.0, 2.0]).is_nan());
    }

    #[test]
    fn oscillation_sees_swings_and_not_drift() {
        let drift: Vec<f64> = (0..200).map(|step| 0.01 * f64::from(step)).collect();
        assert!(oscillation(&drift, 25) < 1e-12);
        let swing: Vec<f64> =
            (0..200).map(|step| 0.01 * f64::from(step) + 0.5 * f64::from(step).sin()).collect();
        assert!((oscillation(&swing, 25) - 1.0).abs() < 0.05);
        let mut jump = vec![0.0; 200];
        jump[100..].fill(1.0);
        assert_eq!(oscillation(&jump, 25), 0.0);
        assert_eq!(oscillation(&[1.0, 2.0], 25), 0.0);
    }

    #[test]
    fn textbook_numbers() {
        let values = [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0];
        assert_eq!(mean(&values), 5.0);
        assert!((standard_deviation(&values) - (32.0f64 / 7.0).sqrt()).abs() < 1e-15);
        assert!((root_mean_square(&[3.0, 4.0]) - 12.5f64.sqrt()).abs() < 1e-15);
        assert_eq!(quantile(&values, 0.5), 4.5);
        assert_eq!(quantile(&values, 1.0), 9.0);
        // t for 2 degrees of freedom at 97.5 % is 4.302653 (tables of Student's t).
        let [low, high] = interval_95(&[1.0, 2.0, 3.0]).unwrap();
        let half = 4.302_652_729_7 / 3f64.sqrt();
        assert!((low - (2.0 - half)).abs() < 1e-6 && (high - (2.0 + half)).abs() < 1e-6);
    }

    #[test]
    fn too_little_data_is_said() {
        assert!(mean(&[]).is_nan() && quantile(&[], 0.5).is_nan());
        assert!(standard_deviation(&[1.0]).is_nan());
        assert_eq!(interval_95(&[1.0]), None);
    }
}
