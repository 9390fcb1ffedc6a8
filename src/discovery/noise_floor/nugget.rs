//! Noise variance from consecutive samples: the nugget, the variogram's limit for zero displacement
//! (Matheron, Economic Geology 58, 1963; from differences in time, Rice, Annals of Statistics 12,
//! 1984). Model errors change with the position and motion of the tip and vanish in this limit.

use nalgebra::{DMatrix, DVector};

use super::NoiseFloor;
use crate::discovery::fit::nuisance::NuisanceFit;
use crate::discovery::recording::covariates::{Covariates, sample_covariates};
use crate::discovery::recording::samples::Samples;

/// Minimum number of consecutive pairs.
const MIN_PAIRS: usize = 20;
/// Correlations beyond this many standard deviations rule the estimate out: noise with memory and
/// model errors cannot be told apart.
const MAX_CORRELATION_SIGMA: f64 = 3.0;
/// Variance of the mean of n half squared consecutive differences over that of n independent ones:
/// neighbours share a sample.
const SHARED_SAMPLE_FACTOR: f64 = 1.5;

/// The nugget of the residual of `nuisance_fit`; `simulated_m` is the simulated tip. None if the
/// residual is correlated, too few samples are consecutive, or none are close to each other.
pub(crate) fn estimate_nugget(
    samples: &Samples,
    nuisance_fit: &NuisanceFit,
    simulated_m: &[f64],
) -> Option<NoiseFloor> {
    let pairs = samples.consecutive_rows();
    // A correlation of white noise has a deviation of 1/√n, over three axes.
    let deviation = 1.0 / (3.0 * pairs.len() as f64).sqrt();
    if pairs.len() < MIN_PAIRS || nuisance_fit.noise.correlation > MAX_CORRELATION_SIGMA * deviation
    {
        return None;
    }
    let moved = moved(&sample_covariates(samples, simulated_m), &pairs);
    // Regress half squared differences on how far the tip moved: the intercept is the noise.
    let inverse = (moved.transpose() * &moved).try_inverse()?;
    let line = |axis: usize| -> (f64, f64) {
        let at = |row: usize| nuisance_fit.residual_m[3 * row + axis];
        let half = |&row: &usize| 0.5 * (at(row) - at(row - 1)).powi(2);
        let halves = DVector::from_iterator(pairs.len(), pairs.iter().map(half));
        let fitted = &inverse * moved.tr_mul(&halves);
        (
            fitted[0],
            (halves - &moved * fitted).norm_squared() / (pairs.len() - moved.ncols()) as f64,
        )
    };
    let lines: [(f64, f64); 3] = std::array::from_fn(line);
    let variance_m2 = lines.map(|(nothing_moves, _)| nothing_moves);
    // About the regression line, noise alone scatters by twice its variance squared; model errors
    // add to this.
    let squares: f64 = variance_m2.iter().map(|variance| 2.0 * variance * variance).sum();
    let scatter: f64 = lines.iter().map(|(_, scatter)| scatter).sum();
    // Noise in model errors, too, makes the intercept less certain than noise alone would.
    let freedom = (squares / scatter).min(1.0) / (SHARED_SAMPLE_FACTOR * inverse[(0, 0)]);
    // A line through convex data may meet the axis below zero.
    let is_sound = variance_m2.iter().all(|variance| *variance >= 0.0) && freedom > 0.0;
    let from = vec!["differences of consecutive samples".to_owned()];
    is_sound.then_some(NoiseFloor { variance_m2, freedom, from, has_repeats: false })
}

/// Regressors, one row a pair: one, squared displacement, and squared change of displacement, the
/// latter two over their means.
fn moved(covariates: &[Covariates], pairs: &[usize]) -> DMatrix<f64> {
    let square = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>();
    let way = |row: usize| square(covariates[row].moved_m);
    let change = |row: usize| {
        square(std::array::from_fn(|axis| {
            covariates[row].moved_m[axis] - covariates[row - 1].moved_m[axis]
        }))
    };
    let column = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
        let values: Vec<f64> = pairs.iter().map(|&row| of(row)).collect();
        // Squares of micrometres beside ones would make the normal matrix singular.
        let mean = crate::math::summary::mean(&values).max(f64::MIN_POSITIVE);
        values.iter().map(|value| value / mean).collect()
    };
    let columns = [column(&|_| 1.0), column(&way), column(&change)];
    DMatrix::from_fn(pairs.len(), columns.len(), |pair, k| columns[k][pair])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discovery::fit::ar1_noise::Ar1Noise;
    use crate::discovery::recording::samples::white_noise;
    use crate::math::summary::{mean, standard_deviation};

    const NOISE_M: f64 = 5e-4;

    /// Six trials of fifty samples of a tip that wanders by some centimetres: samples, positions
    /// and displacements.
    fn wandering(seed: u64) -> (Samples, Vec<f64>, Vec<f64>) {
        let samples = Samples::alike(6, 50);
        let mut step = white_noise(5e-3, seed);
        let (mut simulated_m, mut moved, mut tip) = (Vec::new(), Vec::new(), [0.0; 3]);
        for sample in &samples.rows {
            let moves: [f64; 3] =
                std::array::from_fn(|_| if sample.row == 0 { 0.0 } else { step() });
            tip = std::array::from_fn(
                |axis| if sample.row == 0 { 0.0 } else { tip[axis] + moves[axis] },
            );
            simulated_m.extend(tip);
            moved.extend(moves);
        }
        (samples, simulated_m, moved)
    }

    /// The nugget for noise of this correlation and a model error of `lag` times the displacement
    /// plus `scale` times the position.
    fn told(correlation: f64, [lag, scale]: [f64; 2], seed: u64) -> Option<NoiseFloor> {
        let (samples, simulated_m, moved) = wandering(seed);
        let noise = samples.noise(NOISE_M, correlation, 1000 + seed);
        let residual_m: Vec<f64> =
            (0..noise.len()).map(|k| noise[k] + lag * moved[k] + scale * simulated_m[k]).collect();
        let noise = Ar1Noise::estimate(&samples, &residual_m, 0.0);
        estimate_nugget(
            &samples,
            &NuisanceFit { noise, amounts: DVector::zeros(0), residual_m, deviance: 0.0 },
            &simulated_m,
        )
    }

    #[test]
    fn noise_is_told_as_well_as_it_says_and_apart_from_an_error_that_changes_with_the_motion() {
        for errors in [[0.0, 0.0], [0.1, 0.0]] {
            let found: Vec<NoiseFloor> =
                (0..300).filter_map(|seed| told(0.0, errors, seed)).collect();
            assert!(found.len() > 280, "{errors:?}: {}", found.len());
            let ratios: Vec<f64> =
                found.iter().map(|own| own.variance_m2[0] / NOISE_M.powi(2)).collect();
            assert!((mean(&ratios) - 1.0).abs() < 0.05, "{errors:?}: {}", mean(&ratios));
            let freedom = mean(&found.iter().map(|own| own.freedom).collect::<Vec<f64>>());
            let promised = (2.0 / freedom).sqrt();
            let scatters = standard_deviation(&ratios);
            assert!(
                (scatters / promised - 1.0).abs() < 0.2,
                "{errors:?}: {scatters} of {promised}"
            );
        }
    }

    #[test]
    fn a_memory_is_not_told_from_a_lack() {
        for (correlation, errors) in [(0.6, [0.0, 0.0]), (0.0, [0.0, 0.05])] {
            let found = (0..20).filter(|&seed| told(correlation, errors, seed).is_some()).count();
            assert_eq!(found, 0, "{correlation} {errors:?}");
        }
    }
}
