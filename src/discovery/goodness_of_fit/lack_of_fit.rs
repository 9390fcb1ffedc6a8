//! Lack-of-fit test against pure error: is the mean residual of repeated measurements zero (Draper
//! & Smith, Applied Regression Analysis, section 2.1)?

use super::test_result::{FitTest, TestResult};
use crate::discovery::fit::ar1_noise::{Ar1Noise, effective_axes};
use crate::discovery::noise_floor::NoiseFloor;
use crate::discovery::noise_floor::repeats::{groups, is_start};
use crate::discovery::recording::samples::Samples;

/// Tests the means of `residual_m` (three values a sample) over repeated samples against the noise
/// `floor`. Starts are independent; samples at rest are correlated like `noise`. The size is the
/// root mean square of the means.
pub(crate) fn lack_of_fit_test(
    samples: &Samples,
    residual_m: &[f64],
    noise: &Ar1Noise,
    floor: &NoiseFloor,
) -> TestResult {
    let groups = groups(samples);
    if groups.is_empty() {
        return TestResult { test: FitTest::LackOfFit, p_value: 1.0, more_m: 0.0, beyond_m: 0.0 };
    }
    let (mut squares, mut weighed, mut weights) = (0.0, 0.0, 0.0);
    for group in &groups {
        let independent = if is_start(samples, group) {
            group.len() as f64
        } else {
            noise.independent(group.len()).max(1.0)
        };
        let mean = |axis: usize| {
            group.iter().map(|&row| residual_m[3 * row + axis]).sum::<f64>() / group.len() as f64
        };
        let square: f64 = (0..3).map(|axis| mean(axis).powi(2)).sum();
        // The mean of n samples has 1/n of their variance; n times its square compares with one
        // sample.
        squares += independent * square;
        weighed += group.len() as f64 * square;
        weights += group.len() as f64;
    }
    let p_value = floor.p_value(
        squares / groups.len() as f64,
        effective_axes(&floor.variance_m2) * groups.len() as f64,
    );
    TestResult {
        test: FitTest::LackOfFit,
        p_value,
        more_m: (weighed / weights).sqrt(),
        beyond_m: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discovery::recording::samples::white_noise;

    const NOISE_M: f64 = 5e-4;

    /// Residual of eight trials of ten samples: noise, and a bias at the start.
    fn tested(bias_m: f64, seed: u64) -> TestResult {
        let mut noise = white_noise(NOISE_M, seed);
        let mut samples = Samples::alike(8, 10);
        for sample in &mut samples.rows {
            let bias_m = if sample.row == 0 { bias_m } else { 0.0 };
            sample.position_m = [bias_m + noise(), noise(), noise()];
        }
        let residual_m: Vec<f64> =
            samples.rows.iter().flat_map(|sample| sample.position_m).collect();
        let floor = NoiseFloor::from_repeats(&samples, 0.0);
        lack_of_fit_test(
            &samples,
            &residual_m,
            &Ar1Noise { sigma_m: [NOISE_M; 3], correlation: 0.0 },
            &floor,
        )
    }

    #[test]
    fn a_model_that_is_wrong_at_home_is_seen_and_noise_is_not() {
        let low = (0..200).filter(|&seed| tested(0.0, seed).p_value < 0.05).count();
        assert!((2..22).contains(&low), "{low} of 200 below 0.05");
        let biased = tested(1e-3, 1);
        assert!(biased.p_value < 1e-3, "{}", biased.p_value);
        assert!((biased.more_m / 1e-3 - 1.0).abs() < 0.4, "{}", biased.more_m);
    }
}
