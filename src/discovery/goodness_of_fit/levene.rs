//! Levene's test: is the scatter of the residual equal over the trials? Tracker noise is; an effect
//! that only imitates the missing one is not. Analysis of variance of the distances (Levene, in
//! Contributions to Probability and Statistics, 1960), which is robust against outliers.

use super::test_result::{FitTest, TestResult};
use crate::discovery::fit::nuisance::NuisanceFit;
use crate::discovery::recording::samples::{Samples, rms_m};
use crate::math::distribution::f_above;
use crate::math::summary::{mean, quantile};

/// The test on the residual of `nuisance_fit` in `samples`. The size is the excess of the worst
/// trial over the median trial.
pub(crate) fn levene_test(samples: &Samples, nuisance_fit: &NuisanceFit) -> TestResult {
    let distance_m: Vec<f64> = nuisance_fit.residual_m.chunks_exact(3).map(rms_m).collect();
    let (mut between, mut within) = (0.0, 0.0);
    let mut ranges = samples.ranges();
    ranges.retain(|range| !range.is_empty());
    let all = mean(&distance_m);
    for range in &ranges {
        let in_trial = &distance_m[range.clone()];
        let usual = mean(in_trial);
        between += in_trial.len() as f64 * (usual - all).powi(2);
        within += in_trial.iter().map(|distance| (distance - usual).powi(2)).sum::<f64>();
    }
    // Analysis of variance of the distances: between trials over within trials.
    let groups = ranges.len() as f64;
    // Correlated samples count for fewer.
    let independent = nuisance_fit.noise.independent(samples.len());
    let (above, below) = (groups - 1.0, (independent - groups).max(1.0));
    let ratio = between / above / (within / below).max(f64::MIN_POSITIVE);
    // The size is told in metres, since the ratio says nothing of relevance.
    let each: Vec<f64> = ranges
        .iter()
        .map(|r| rms_m(&nuisance_fit.residual_m[3 * r.start..3 * r.end]).powi(2))
        .collect();
    let worst = each.iter().copied().fold(0.0, f64::max);
    let middle = quantile(&each, 0.5);
    TestResult {
        test: FitTest::Levene,
        p_value: f_above(ratio, above, below),
        more_m: (worst - middle).max(0.0).sqrt(),
        beyond_m: middle.max(0.0).sqrt(),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;
    use crate::discovery::fit::ar1_noise::Ar1Noise;
    use crate::discovery::recording::samples::white_noise;

    const NOISE_M: f64 = 5e-4;

    /// Six trials of fifty samples of noise, one of them larger by a factor.
    fn tested(times: f64, seed: u64) -> TestResult {
        let mut noise = white_noise(NOISE_M, seed);
        let residual_m = (0..900)
            .map(|k| if (300..450).contains(&k) { times * noise() } else { noise() })
            .collect();
        let noise = Ar1Noise { sigma_m: [NOISE_M; 3], correlation: 0.0 };
        levene_test(
            &Samples::alike(6, 50),
            &NuisanceFit { noise, amounts: DVector::zeros(0), residual_m, deviance: 0.0 },
        )
    }

    #[test]
    fn one_trial_that_scatters_more_is_seen_and_even_noise_is_not() {
        let even: Vec<f64> = (0..200).map(|seed| tested(1.0, seed).p_value).collect();
        let low = even.iter().filter(|p| **p < 0.05).count();
        assert!((2..22).contains(&low), "{low} of 200 below 0.05");
        let uneven = tested(1.6, 1);
        assert!(uneven.p_value < 1e-4, "{}", uneven.p_value);
        let more_m = 3.0_f64.sqrt() * NOISE_M * (1.6_f64.powi(2) - 1.0).sqrt();
        assert!((uneven.more_m / more_m - 1.0).abs() < 0.3, "{}", uneven.more_m);
    }
}
