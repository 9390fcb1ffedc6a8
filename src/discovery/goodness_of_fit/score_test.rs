//! Would all effects of the catalogue together, a little of each, explain more of what is left than they do of noise? None
//! of them need do much by itself: what a set of effects only imitates is left over in many directions at once. The score
//! test (Rao, Proceedings of the Cambridge Philosophical Society 44, 1948), its noise estimated from the rest as in a test
//! for lack of fit (Draper & Smith, Applied Regression Analysis, section 1.5).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, SymmetricEigen};

use crate::discovery::fit::gauss_newton::FittedSet;
use crate::discovery::fit::nuisance::Nuisances;
use crate::discovery::recording::samples::Samples;
use crate::math::distribution::f_above;

/// What all effects together explain of what is left.
pub(crate) struct ScoreTestResult {
    /// Chance of as much from noise.
    pub(crate) p_value: f64,
    /// What they explain beyond what so many numbers explain of noise, root mean square, metres; at least, where noise is
    /// correlated.
    pub(crate) more_m: f64,
}

/// Directions in which the tip answers by less than this share of the strongest, in squares, are noise of the answers; so
/// are those that are weaker beside a single answer of length one.
const LEAST_DIRECTION: f64 = 1e-3;
/// Added to the diagonal of what is free, as a share of it, so that columns may be alike.
const RIDGE: f64 = 1e-9;

/// The test on what `fitted` leaves in `samples`: `nuisances` are free within their uncertainty and the members' numbers
/// without any. `answers`: what a little of every effect does to the tip, a column each, three numbers a sample. None where
/// there are too few samples for so many effects, or no effects.
pub(crate) fn score_test(
    samples: &Samples,
    nuisances: &Nuisances,
    fitted: &FittedSet,
    answers: &DMatrix<f64>,
) -> Option<ScoreTestResult> {
    let noise = &fitted.nuisance_fit.noise;
    let free = noise.whitened(samples, &nuisances.with(&fitted.jacobian));
    let answers = of_length_one(&noise.whitened(samples, answers));
    if answers.is_empty() {
        return None;
    }
    let factor = factor(nuisances, &free)?;
    let beyond = &answers - &free * factor.solve(&free.tr_mul(&answers));
    let left = DVector::from_vec(noise.whiten(samples, &fitted.nuisance_fit.residual_m));
    // A fit may end at the end of a range or short of its best: the members' numbers take what they still can (Neyman's
    // C(alpha)). Nuisances are at their most likely amounts.
    let mut pull = free.tr_mul(&left);
    pull.rows_mut(0, nuisances.columns.ncols()).fill(0.0);
    let left = &left - &free * factor.solve(&pull);
    let scores = answers.tr_mul(&left);
    let directions = SymmetricEigen::new(answers.tr_mul(&beyond));
    let least = LEAST_DIRECTION * directions.eigenvalues.max().max(1.0);
    let (mut taken, mut count) = (0.0, 0);
    for (direction, &variance) in directions.eigenvectors.column_iter().zip(&directions.eigenvalues) {
        if variance > least {
            taken += direction.dot(&scores).powi(2) / variance;
            count += 1;
        }
    }
    let numbers = left.len();
    // All that is free, though a prior leaves it less: on the safe side.
    let freedom = numbers.checked_sub(count + free.ncols()).filter(|freedom| *freedom > 0)? as f64;
    let rest = (left.norm_squared() - taken).max(0.0) / freedom;
    let more = (taken - count as f64 * rest).max(0.0) / numbers as f64;
    Some(ScoreTestResult {
        p_value: f_above(taken / (count.max(1) as f64 * rest.max(f64::MIN_POSITIVE)), count as f64, freedom),
        more_m: more.sqrt() * noise.rms_m(),
    })
}

/// Factor of the information on what is free; the ridge carries a column that is zero, too.
fn factor(nuisances: &Nuisances, free: &DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
    let mut information = nuisances.information(free);
    let largest = information.diagonal().max();
    for k in 0..information.ncols() {
        let diagonal = information[(k, k)];
        information[(k, k)] += RIDGE * if diagonal > 0.0 { diagonal } else { largest };
    }
    Cholesky::new(information)
}

/// Columns that are zero are left out.
fn of_length_one(columns: &DMatrix<f64>) -> DMatrix<f64> {
    let kept: Vec<DVector<f64>> =
        columns.column_iter().filter(|column| column.norm() > 0.0).map(|column| column.normalize()).collect();
    DMatrix::from_fn(columns.nrows(), kept.len(), |row, k| kept[k][row])
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

    /// The test on noise of this correlation and so much of all waves, the first wave uncertain and the second fitted.
    fn tested(correlation: f64, each_m: f64, seed: u64) -> ScoreTestResult {
        short_of_best(correlation, each_m, 0.0, seed)
    }

    /// The same where the fit of the second wave has ended by so much too soon.
    fn short_of_best(correlation: f64, each_m: f64, short_m: f64, seed: u64) -> ScoreTestResult {
        let (samples, waves) = (Samples::alike(6, 50), waves());
        let mut residual_m = samples.noise(NOISE_M, correlation, seed);
        for (left, wave) in residual_m.iter_mut().zip(waves.row_iter()) {
            *left += each_m * wave.sum();
        }
        let own = |k: usize| (waves.column(k).as_slice().to_vec(), 1.0);
        let nuisances = Nuisances::independent(900, &[own(0)]);
        let mut nuisance_fit = Nuisances::independent(900, &[own(0), own(1)]).explain(&samples, &residual_m, 0.0);
        // The effect that was fitted answers a little otherwise where it is.
        let jacobian = waves.columns(1, 1) + 0.1 * waves.columns(4, 1);
        for (left, answer) in nuisance_fit.residual_m.iter_mut().zip(jacobian.iter()) {
            *left += short_m * answer;
        }
        let fitted = FittedSet { members: Vec::new(), nuisance_fit, simulated_m: vec![0.0; 900], jacobian };
        score_test(&samples, &nuisances, &fitted, &waves).unwrap()
    }

    #[test]
    fn noise_is_not_explained_be_it_white_or_not() {
        for correlation in [0.0, 0.6] {
            let low = (0..200).filter(|&seed| tested(correlation, 0.0, seed).p_value < 0.05).count();
            assert!((2..22).contains(&low), "{correlation}: {low} of 200 below 0.05");
        }
    }

    /// Of every wave so little that it would not be seen by itself among thirty.
    #[test]
    fn a_little_of_everything_is_seen() {
        let each_m = 0.2 * NOISE_M;
        for seed in 0..20 {
            let found = tested(0.0, each_m, seed);
            assert!(found.p_value < 1e-3, "{seed}: {}", found.p_value);
            // Twenty-eight waves are left, each of which has half a square in one number of three.
            let more_m = (14.0_f64).sqrt() * each_m;
            assert!((found.more_m / more_m - 1.0).abs() < 0.3, "{seed}: {} of {more_m}", found.more_m);
        }
    }

    /// As where a number ends at the end of its range.
    #[test]
    fn a_fit_that_ended_too_soon_is_nothing_new() {
        for seed in 0..20 {
            let found = short_of_best(0.0, 0.0, NOISE_M, seed);
            assert!(found.p_value > 1e-3, "{seed}: {}", found.p_value);
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
        assert!(score_test(&samples, &nuisances, &fitted, &waves()).is_some_and(|found| found.p_value > 0.01));
    }
}
