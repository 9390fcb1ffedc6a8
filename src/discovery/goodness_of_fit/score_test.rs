//! Score test: do small amounts of all effects together explain more of the residual than of noise?
//! An imitation leaves residuals in many directions at once (Rao, Proceedings of the Cambridge
//! Philosophical Society 44, 1948; noise estimated from the remainder as in Draper & Smith, Applied
//! Regression Analysis, section 1.5).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, SymmetricEigen};

use super::test_result::{FitTest, TestResult};
use crate::discovery::fit::gauss_newton::FittedSet;
use crate::discovery::fit::nuisance::Nuisances;
use crate::discovery::recording::samples::Samples;
use crate::math::distribution::f_above;

/// Directions weaker than this share of the strongest, in squares, are ignored; so are those this
/// weak relative to one column.
const MIN_DIRECTION_SHARE: f64 = 1e-3;
/// Relative ridge on free parameters.
const RELATIVE_RIDGE: f64 = 1e-9;

/// The test on the residual of `fitted` in `samples`. `sensitivities`: sensitivities to all
/// effects, one column each, three rows a sample. The size is the explained part beyond that
/// expected from noise, a lower bound for correlated noise. None with too few samples or without
/// effects.
pub(crate) fn score_test(
    samples: &Samples,
    nuisances: &Nuisances,
    fitted: &FittedSet,
    sensitivities: &DMatrix<f64>,
) -> Option<TestResult> {
    let noise = &fitted.nuisance_fit.noise;
    let free = noise.whitened(samples, &nuisances.with(&fitted.jacobian));
    let sensitivities = normalised(&noise.whitened(samples, sensitivities));
    if sensitivities.is_empty() {
        return None;
    }
    let factor = factor(nuisances, &free)?;
    // Project the responses on what the free parameters cannot explain.
    let beyond = &sensitivities - &free * factor.solve(&free.tr_mul(&sensitivities));
    let residual = DVector::from_vec(noise.whiten(samples, &fitted.nuisance_fit.residual_m));
    // The fit may be short of its optimum: member parameters take what they still can (Neyman's
    // C(α)). Nuisance parameters are at their most likely values.
    let mut pull = free.tr_mul(&residual);
    pull.rows_mut(0, nuisances.columns.ncols()).fill(0.0);
    let residual = &residual - &free * factor.solve(&pull);
    let scores = sensitivities.tr_mul(&residual);
    // The score statistic in the directions that the free parameters leave determined.
    let directions = SymmetricEigen::new(sensitivities.tr_mul(&beyond));
    let min_variance = MIN_DIRECTION_SHARE * directions.eigenvalues.max().max(1.0);
    // Nearly collinear responses would divide noise by nothing.
    let (mut explained, mut count) = (0.0, 0);
    for (direction, &variance) in directions.eigenvectors.column_iter().zip(&directions.eigenvalues)
    {
        if variance > min_variance {
            explained += direction.dot(&scores).powi(2) / variance;
            count += 1;
        }
    }
    let numbers = residual.len();
    // Conservative: priors reduce the number of free parameters.
    let freedom = numbers.checked_sub(count + free.ncols()).filter(|freedom| *freedom > 0)? as f64;
    // The unexplained rest estimates the noise; what was fitted already flatters it.
    let rest = (residual.norm_squared() - explained).max(0.0) / freedom;
    // Noise alone explains its variance once in each direction.
    let more = (explained - count as f64 * rest).max(0.0) / numbers as f64;
    Some(TestResult {
        test: FitTest::Score,
        p_value: f_above(
            explained / (count.max(1) as f64 * rest.max(f64::MIN_POSITIVE)),
            count as f64,
            freedom,
        ),
        more_m: more.sqrt() * noise.rms_m(),
        beyond_m: 0.0,
    })
}

/// Cholesky factor of the information of free parameters with a ridge.
fn factor(nuisances: &Nuisances, free: &DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
    let mut information = nuisances.information(free);
    let largest = information.diagonal().max();
    for k in 0..information.ncols() {
        let diagonal = information[(k, k)];
        information[(k, k)] += RELATIVE_RIDGE * if diagonal > 0.0 { diagonal } else { largest };
    }
    Cholesky::new(information)
}

/// Normalised columns without zero columns.
fn normalised(columns: &DMatrix<f64>) -> DMatrix<f64> {
    let normalised: Vec<DVector<f64>> = columns
        .column_iter()
        .filter(|column| column.norm() > 0.0)
        .map(|column| column.normalize())
        .collect();
    DMatrix::from_fn(columns.nrows(), normalised.len(), |row, k| normalised[k][row])
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const NOISE_M: f64 = 5e-4;

    /// Waves along six trials of fifty samples, ten along each axis.
    fn waves() -> DMatrix<f64> {
        DMatrix::from_fn(900, 30, |at, wave| {
            let (row, axis) = (at / 3, at % 3);
            let turns = (1 + wave / 3) as f64 * row as f64 / 100.0;
            if wave % 3 == axis { (TAU * turns).sin() } else { 0.0 }
        })
    }

    /// The test on noise of this correlation with this amplitude of all waves; the first wave is
    /// uncertain, the second fitted.
    fn tested(correlation: f64, each_m: f64, seed: u64) -> TestResult {
        short_of_best(correlation, each_m, 0.0, seed)
    }

    /// The same with the fit of the second wave short of its optimum.
    fn short_of_best(correlation: f64, each_m: f64, short_m: f64, seed: u64) -> TestResult {
        let (samples, waves) = (Samples::alike(6, 50), waves());
        let mut residual_m = samples.noise(NOISE_M, correlation, seed);
        for (left, wave) in residual_m.iter_mut().zip(waves.row_iter()) {
            *left += each_m * wave.sum();
        }
        let own = |k: usize| (waves.column(k).as_slice().to_vec(), 1.0);
        let nuisances = Nuisances::independent(900, &[own(0)]);
        let mut nuisance_fit =
            Nuisances::independent(900, &[own(0), own(1)]).explain(&samples, &residual_m, 0.0);
        // The Jacobian at the fit differs slightly from the sensitivity.
        let jacobian = waves.columns(1, 1) + 0.1 * waves.columns(4, 1);
        for (left, answer) in nuisance_fit.residual_m.iter_mut().zip(jacobian.iter()) {
            *left += short_m * answer;
        }
        let fitted =
            FittedSet { members: Vec::new(), nuisance_fit, simulated_m: vec![0.0; 900], jacobian };
        score_test(&samples, &nuisances, &fitted, &waves).unwrap()
    }

    #[test]
    fn noise_is_not_explained_be_it_white_or_not() {
        for correlation in [0.0, 0.6] {
            let low =
                (0..200).filter(|&seed| tested(correlation, 0.0, seed).p_value < 0.05).count();
            assert!((2..22).contains(&low), "{correlation}: {low} of 200 below 0.05");
        }
    }

    /// Amplitudes that are invisible in any single wave.
    #[test]
    fn a_little_of_everything_is_seen() {
        let each_m = 0.2 * NOISE_M;
        for seed in 0..20 {
            let result = tested(0.0, each_m, seed);
            assert!(result.p_value < 1e-3, "{seed}: {}", result.p_value);
            // Twenty-eight waves remain, each with half a square on one of three axes.
            let more_m = (14.0_f64).sqrt() * each_m;
            assert!(
                (result.more_m / more_m - 1.0).abs() < 0.3,
                "{seed}: {} of {more_m}",
                result.more_m
            );
        }
    }

    /// As for a parameter at the end of its range.
    #[test]
    fn a_fit_that_ended_too_soon_is_nothing_new() {
        for seed in 0..20 {
            let result = short_of_best(0.0, 0.0, NOISE_M, seed);
            assert!(result.p_value > 1e-3, "{seed}: {}", result.p_value);
        }
    }

    #[test]
    fn where_nothing_can_be_explained_nothing_is_said() {
        let (samples, nothing) = (Samples::alike(6, 50), DMatrix::zeros(900, 0));
        let nuisances = Nuisances::independent(900, &[]);
        let nuisance_fit = nuisances.explain(&samples, &samples.noise(NOISE_M, 0.0, 0), 0.0);
        let fitted = FittedSet {
            members: Vec::new(),
            nuisance_fit,
            simulated_m: vec![0.0; 900],
            jacobian: DMatrix::zeros(900, 0),
        };
        assert!(score_test(&samples, &nuisances, &fitted, &nothing).is_none());
        assert!(score_test(&samples, &nuisances, &fitted, &DMatrix::zeros(900, 2)).is_none());
        assert!(
            score_test(&samples, &nuisances, &fitted, &waves())
                .is_some_and(|result| result.p_value > 0.01)
        );
    }
}
