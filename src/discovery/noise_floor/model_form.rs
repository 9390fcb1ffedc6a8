//! Model-form error: what the calibrated model leaves on a trial of the baseline when its
//! correction is fitted to the other trials. A robot whose physics is not exactly the model's is
//! judged by this, not by noise alone (Kennedy & O'Hagan, Journal of the Royal Statistical Society
//! B 63, 2001, call it model inadequacy).

use super::NoiseFloor;
use crate::discovery::fit::ar1_noise::effective_axes;
use crate::discovery::fit::nuisance::{NuisanceFit, Nuisances};
use crate::discovery::recording::samples::{Samples, rms_m};
use crate::math::distribution::f_above;
use crate::math::summary::mean;

/// Significance level at which the worst trial of the baseline exceeds its noise.
const SIGNIFICANCE: f64 = 0.01;

/// What a calibrated model leaves of its baseline.
pub(crate) struct ModelForm {
    /// What is left of each trial when its correction is fitted to the others, three values a
    /// sample, metres.
    pub(crate) unseen_m: Vec<f64>,
    /// Model-form error, metres: what the model leaves beyond noise in the worst trial, because the
    /// error differs with the poses and any trial may be of that kind. Zero if no trial exceeds the
    /// noise.
    pub(crate) worst_m: f64,
    /// Whether the model as it is, without any correction, leaves significantly more than noise.
    pub(crate) is_inexact: bool,
}

impl ModelForm {
    /// Of a model that simulates `simulated_m` in the baseline's `samples`; `nuisances`: those of
    /// the baseline by their priors.
    pub(crate) fn new(samples: &Samples, simulated_m: &[f64], nuisances: &Nuisances) -> ModelForm {
        let residual_m = samples.residual(simulated_m);
        let whole = nuisances.explain(samples, &residual_m, 0.0);
        // The fit of all trials has the least model error in it, so its differences show the noise.
        let floor = NoiseFloor::estimate(samples, &whole, simulated_m);
        let unseen_m = unseen_residual_m(samples, simulated_m, nuisances);
        let freedom = effective_axes(&floor.variance_m2) * whole.noise.independent(samples.len());
        let is_inexact = floor.freedom < 1.0
            || floor.p_value(rms_m(&residual_m).powi(2), freedom) < SIGNIFICANCE;
        ModelForm { worst_m: worst_m(samples, &unseen_m, &whole, &floor), unseen_m, is_inexact }
    }
}

/// What the worst trial of the residual `unseen_m` has beyond noise, metres. `whole`: the fit of
/// all trials together.
fn worst_m(samples: &Samples, unseen_m: &[f64], whole: &NuisanceFit, floor: &NoiseFloor) -> f64 {
    let ranges = samples.ranges();
    let squares_m2: Vec<f64> =
        ranges.iter().map(|rows| rms_m(&unseen_m[3 * rows.start..3 * rows.end]).powi(2)).collect();
    // The error depends on the poses, and the measured recording may hold any of them.
    let Some(worst) = (0..ranges.len()).max_by(|&a, &b| squares_m2[a].total_cmp(&squares_m2[b]))
    else {
        return 0.0;
    };
    if floor.freedom < 1.0 {
        // Nothing tells the noise: all of the residual is what this model leaves on this robot.
        return squares_m2[worst].sqrt();
    }
    let axes = effective_axes(&floor.variance_m2);
    let freedom = |trials: &dyn Fn(usize) -> bool| {
        let rows =
            (0..ranges.len()).filter(|&trial| trials(trial)).map(|trial| ranges[trial].len()).sum();
        axes * whole.noise.independent(rows).max(1.0)
    };
    let others: Vec<f64> =
        (0..ranges.len()).filter(|&trial| trial != worst).map(|trial| squares_m2[trial]).collect();
    let rest_m2 = mean(&others);
    let worst_freedom = freedom(&|trial| trial == worst);
    // Bonferroni's correction: the worst of so many trials, beside the others and beside the floor.
    let level = SIGNIFICANCE / (2.0 * ranges.len() as f64);
    let beside_others =
        f_above(squares_m2[worst] / rest_m2, worst_freedom, freedom(&|trial| trial != worst))
            < level;
    let beside_floor = floor.p_value(squares_m2[worst], worst_freedom) < level;
    let more_m2 = |significant: bool, noise_m2: f64| {
        if significant { squares_m2[worst] - noise_m2 } else { 0.0 }
    };
    more_m2(beside_others, rest_m2)
        .max(more_m2(beside_floor, floor.rms_m().powi(2)))
        .max(0.0)
        .sqrt()
}

/// The residual of each trial after correction by nuisance parameters that were fitted to the other
/// trials, three values a sample. A single trial is corrected by its own fit.
fn unseen_residual_m(samples: &Samples, simulated_m: &[f64], nuisances: &Nuisances) -> Vec<f64> {
    let residual_m = samples.residual(simulated_m);
    let ranges = samples.ranges();
    if ranges.len() < 2 {
        return nuisances.explain(samples, &residual_m, 0.0).residual_m;
    }
    let mut unseen_m = Vec::with_capacity(residual_m.len());
    for (trial, range) in ranges.iter().enumerate() {
        let in_trial: Vec<usize> = (3 * range.start..3 * range.end).collect();
        let others: Vec<usize> =
            (0..residual_m.len()).filter(|row| !in_trial.contains(row)).collect();
        let other_trials: Vec<usize> = (0..ranges.len()).filter(|other| *other != trial).collect();
        let seen = samples.of_trials(&other_trials);
        let part = |rows: &[usize]| rows.iter().map(|&row| residual_m[row]).collect::<Vec<f64>>();
        let before = nuisances.in_rows(&others);
        // 1. Fit the correction to the other trials.
        let fitted = before.explain(&seen, &part(&others), 0.0);
        let precision = before.information(&fitted.noise.whitened(&seen, &before.columns));
        // 2. Its posterior is the prior of the trial that is left out.
        let after = nuisances.in_rows(&in_trial).with_prior(fitted.amounts, precision);
        unseen_m
            .extend(after.explain(&samples.of_trials(&[trial]), &part(&in_trial), 0.0).residual_m);
    }
    unseen_m
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOISE_M: f64 = 5e-4;

    /// Model-form error of eight trials of fifty samples with noise; in the last one a wave of this
    /// height is added.
    fn told_m(wave_m: f64, seed: u64) -> f64 {
        let mut samples = Samples::alike(8, 50);
        let noise_m = samples.noise(NOISE_M, 0.0, seed);
        for (sample, noise_m) in samples.rows.iter_mut().zip(noise_m.chunks_exact(3)) {
            let height_m = if sample.trial == 7 { wave_m } else { 0.0 };
            sample.position_m =
                [height_m * (0.5 * sample.row as f64).sin() + noise_m[0], noise_m[1], noise_m[2]];
        }
        let simulated_m = vec![0.0; 3 * samples.len()];
        // A constant that all trials share explains none of it.
        let shift: Vec<f64> =
            (0..simulated_m.len()).map(|k| if k % 3 == 0 { 1.0 } else { 0.0 }).collect();
        let nuisances = Nuisances::independent(simulated_m.len(), &[(shift, 1e-3)]);
        ModelForm::new(&samples, &simulated_m, &nuisances).worst_m
    }

    #[test]
    fn what_the_worst_trial_has_beyond_noise_is_told_and_noise_is_not() {
        let false_alarms = (0..100).filter(|&seed| told_m(0.0, seed) > 0.0).count();
        assert!(false_alarms <= 6, "{false_alarms} of 100");
        let (found_m, true_m) = (told_m(2e-3, 1), 2e-3 / 2.0_f64.sqrt());
        assert!((found_m / true_m - 1.0).abs() < 0.15, "{found_m} of {true_m}");
    }
}
