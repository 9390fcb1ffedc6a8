//! Noise floor from the data: repeated starts at home, dwells at rest, and differences of
//! consecutive samples, in which model errors hardly appear.

pub(crate) mod dwell_ar1;
pub(crate) mod model_form;
pub(crate) mod nugget;
pub(crate) mod repeats;
pub(crate) mod trial_starts;

use super::fit::ar1_noise::effective_axes;
use super::fit::nuisance::NuisanceFit;
use super::recording::samples::Samples;
use crate::math::distribution::f_above;
use dwell_ar1::SquareSumMoments;
use nugget::estimate_nugget;
use repeats::{groups, is_start, starts};

/// An estimate of the measurement noise.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NoiseFloor {
    /// Variance along x, y and z, m².
    pub(crate) variance_m2: [f64; 3],
    /// Degrees of freedom of each variance.
    pub(crate) freedom: f64,
    /// Sources of the estimate, as text.
    pub(crate) from: Vec<String>,
    /// Whether repeated measurements are among them: else a model's error may be in it.
    pub(crate) has_repeats: bool,
}

/// Significance level at which two estimates contradict each other. It is low because consecutive
/// differences can miss noise with memory and because few repeats scatter widely.
const CONTRADICTION_SIGNIFICANCE: f64 = 1e-5;

impl NoiseFloor {
    /// Pooled estimate from repeats, dwells and consecutive differences. The differences are used
    /// only if the residual in `nuisance_fit` is uncorrelated and repeats do not contradict them.
    /// `simulated_m`: simulated tip.
    pub(crate) fn estimate(
        samples: &Samples,
        nuisance_fit: &NuisanceFit,
        simulated_m: &[f64],
    ) -> NoiseFloor {
        let repeats = NoiseFloor::from_repeats(samples, nuisance_fit.noise.correlation);
        let neighbours = estimate_nugget(samples, nuisance_fit, simulated_m);
        match neighbours.filter(|neighbours| !repeats.contradicts(neighbours)) {
            Some(neighbours) => repeats.combined_with(neighbours),
            None => repeats,
        }
    }

    /// The residual of a fit, taken as noise.
    pub(crate) fn of_residual(nuisance_fit: &NuisanceFit, samples: &Samples) -> NoiseFloor {
        NoiseFloor {
            variance_m2: nuisance_fit.noise.sigma_m.map(|sigma| sigma * sigma),
            freedom: nuisance_fit.noise.independent(samples.len()),
            from: vec!["the residual of the model".to_owned()],
            has_repeats: false,
        }
    }

    /// From repeated starts and dwells; zero degrees of freedom without either. `correlation`: that
    /// of the residual, used unless dwells contradict it.
    pub(crate) fn from_repeats(samples: &Samples, correlation: f64) -> NoiseFloor {
        NoiseFloor::from_groups(samples, &groups(samples), correlation)
    }

    /// From the first rows of trials alone.
    pub(crate) fn from_starts(samples: &Samples) -> NoiseFloor {
        NoiseFloor::from_groups(samples, &starts(samples), 0.0)
    }

    /// From groups of samples, each of one pose.
    fn from_groups(samples: &Samples, groups: &[Vec<usize>], correlation: f64) -> NoiseFloor {
        let (starts, dwells): (Vec<&[usize]>, Vec<&[usize]>) =
            groups.iter().map(Vec::as_slice).partition(|group| is_start(samples, group));
        let correlation = dwell_ar1::correlation(samples, &dwells, correlation);
        // Starts are independent; samples at rest are correlated.
        let moments =
            SquareSumMoments::of(starts.iter().map(|group| group.len()), 0.0).combined_with(
                SquareSumMoments::of(dwells.iter().map(|group| group.len()), correlation),
            );
        let squares_m2: Vec<[f64; 3]> =
            groups.iter().map(|group| dwell_ar1::squares_m2(samples, group)).collect();
        let variance = |axis: usize| {
            squares_m2.iter().map(|squares| squares[axis]).sum::<f64>()
                / moments.mean.max(f64::MIN_POSITIVE)
        };
        let [starts, dwells] =
            [starts, dwells].map(|groups| groups.iter().map(|group| group.len()).sum::<usize>());
        let mut from = Vec::new();
        from.extend((starts > 1).then(|| format!("{starts} starts at home")));
        from.extend((dwells > 1).then(|| format!("{dwells} samples at rest")));
        NoiseFloor {
            variance_m2: std::array::from_fn(variance),
            freedom: moments.freedom(),
            has_repeats: !from.is_empty(),
            from,
        }
    }

    /// Root mean square distance, metres.
    pub(crate) fn rms_m(&self) -> f64 {
        self.variance_m2.iter().sum::<f64>().sqrt()
    }

    /// Probability that noise of this floor has this variance or more (all axes together).
    pub(crate) fn p_value(&self, variance_m2: f64, freedom: f64) -> f64 {
        let floor_m2: f64 = self.variance_m2.iter().sum();
        // Two repeats or none say nothing: no test may fail because of them.
        if self.freedom < 2.0 || floor_m2 <= 0.0 {
            return 1.0;
        }
        f_above(variance_m2 / floor_m2, freedom, effective_axes(&self.variance_m2) * self.freedom)
    }

    /// Probability that noise of this floor yields `other` or more.
    pub(crate) fn p_value_of(&self, other: &NoiseFloor) -> f64 {
        self.p_value(
            other.variance_m2.iter().sum(),
            effective_axes(&other.variance_m2) * other.freedom,
        )
    }

    /// Whether `other` is significantly larger.
    pub(crate) fn is_exceeded_by(&self, other: &NoiseFloor) -> bool {
        self.p_value_of(other) < CONTRADICTION_SIGNIFICANCE
    }

    fn contradicts(&self, other: &NoiseFloor) -> bool {
        self.freedom > 0.0 && (self.is_exceeded_by(other) || other.is_exceeded_by(self))
    }

    /// Pooled estimate of both.
    pub(crate) fn combined_with(self, other: NoiseFloor) -> NoiseFloor {
        if self.freedom <= 0.0 {
            return other;
        }
        let all = self.freedom + other.freedom;
        // Pool variances by degrees of freedom, as in an analysis of variance.
        let mean = |axis: usize| {
            (self.freedom * self.variance_m2[axis] + other.freedom * other.variance_m2[axis]) / all
        };
        NoiseFloor {
            variance_m2: std::array::from_fn(mean),
            freedom: all,
            has_repeats: self.has_repeats || other.has_repeats,
            from: [self.from, other.from].concat(),
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;
    use crate::base::Rows;
    use crate::discovery::fit::ar1_noise::Ar1Noise;
    use crate::discovery::recording::samples::white_noise;

    const NOISE_M: f64 = 5e-4;

    #[test]
    fn starts_under_another_weight_are_no_repeats() {
        let mut samples = Samples::alike(4, 1);
        for (k, (trial, sample)) in samples.trials.iter_mut().zip(&mut samples.rows).enumerate() {
            let weighed = k % 2 == 1;
            trial.known_load_kg = if weighed { 0.02 } else { 0.0 };
            sample.position_m =
                [if weighed { 0.01 } else { 0.0 } + 1e-4 * (k / 2) as f64, 0.0, 0.2];
        }
        let floor = NoiseFloor::from_repeats(&samples, 0.0);
        assert_eq!((floor.freedom, floor.from), (2.0, vec!["4 starts at home".to_owned()]));
        assert!((floor.variance_m2[0] - 0.5e-8).abs() < 1e-15, "{:?}", floor.variance_m2);
    }

    /// Consecutive differences help where few repeats scatter little by chance, and are not used
    /// where repeats contradict them.
    #[test]
    fn neighbours_help_where_repeats_do_not_contradict_them() {
        for (starts, all) in [(1.0, 1.0), (0.4, 1.0), (0.05, 0.05)] {
            let mut samples = Samples::alike(6, 50);
            let residual_m = samples.noise(NOISE_M, 0.0, 1);
            let mut place = white_noise(0.01, 2);
            let simulated_m: Vec<f64> = residual_m.iter().map(|_| place()).collect();
            for (row, sample) in samples.rows.iter_mut().enumerate() {
                let times = if sample.row == 0 { starts } else { 1.0 };
                sample.position_m = std::array::from_fn(|axis| times * residual_m[3 * row + axis]);
            }
            let noise = Ar1Noise::estimate(&samples, &residual_m, 0.0);
            let nuisance_fit =
                NuisanceFit { noise, amounts: DVector::zeros(0), residual_m, deviance: 0.0 };
            let floor = NoiseFloor::estimate(&samples, &nuisance_fit, &simulated_m);
            let ratio = floor.rms_m() / (3.0_f64.sqrt() * NOISE_M);
            assert!(
                floor.has_repeats && !NoiseFloor::of_residual(&nuisance_fit, &samples).has_repeats
            );
            assert!((ratio / all - 1.0).abs() < 0.25, "{starts}: {ratio}, {:?}", floor.from);
        }
    }

    /// Six trials at rest under correlated noise.
    #[test]
    fn rests_in_noise_that_remembers_say_how_large_it_is() {
        for correlation in [0.0_f64, 0.5, 0.8, 0.9] {
            let (mut ratios, mut low) = (Vec::new(), 0);
            for seed in 0..200 {
                let mut samples = Samples::alike(6, 50);
                for trial in &mut samples.trials {
                    // Four poses, each held for 2.5 s.
                    trial.commands = Rows::new(1);
                    (1..50).for_each(|k| trial.commands.push(&[f64::from(k / 13)]));
                }
                let residual_m = samples.noise(NOISE_M, correlation, seed);
                for (sample, residual_m) in samples.rows.iter_mut().zip(residual_m.as_chunks().0) {
                    sample.position_m = *residual_m;
                }
                let floor = NoiseFloor::from_repeats(&samples, correlation);
                ratios.push((floor.rms_m() / NOISE_M).powi(2) / 3.0);
                let all_m2 =
                    samples.rows.iter().flat_map(|row| row.position_m).map(|x| x * x).sum::<f64>()
                        / 300.0;
                let known = Ar1Noise { sigma_m: [NOISE_M; 3], correlation };
                low += usize::from(floor.p_value(all_m2, 3.0 * known.independent(300)) < 0.05);
            }
            let mean = crate::math::summary::mean(&ratios);
            assert!((mean - 1.0).abs() < 0.05, "{correlation}: {mean}");
            assert!(low < 20, "{correlation}: {low} of 200 below 0.05");
        }
    }
}
