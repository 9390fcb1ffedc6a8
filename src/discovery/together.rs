//! Would all effects of the catalogue together, a little of each, explain more of what is left than they do of noise? None
//! of them need do much by itself: what a set of effects only imitates is left over in many directions at once. The score
//! test (Rao, Proceedings of the Cambridge Philosophical Society 44, 1948), its noise estimated from the rest as in a test
//! for lack of fit (Draper & Smith, Applied Regression Analysis, section 1.5).

use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};

use super::nuisance::Nuisances;
use super::refit::Fitted;
use super::samples::Samples;
use crate::math::distribution::f_above;

/// What all effects together explain of what is left.
pub(super) struct Together {
    /// Chance of as much from noise.
    pub(super) p_value: f64,
    /// What they explain beyond what so many numbers explain of noise, root mean square, metres.
    pub(super) more_m: f64,
}

/// Directions in which the tip answers by less than this share of the strongest, in squares, are noise of the answers.
const LEAST_DIRECTION: f64 = 1e-3;
/// Added to the diagonal of what is free, so that columns may be alike.
const RIDGE: f64 = 1e-9;

/// The test on what `fitted` leaves in `samples`: `nuisances` are free within their uncertainty and the members' sizes
/// without any. `answers`: what a little of every effect does to the tip, a column each, three numbers a sample. None where
/// nothing can be tested.
pub(super) fn together(
    samples: &Samples,
    nuisances: &Nuisances,
    fitted: &Fitted,
    answers: &DMatrix<f64>,
) -> Option<Together> {
    let noise = &fitted.explained.noise;
    let free = noise.whitened(samples, &nuisances.with(&fitted.jacobian));
    let own = of_length_one(noise.whitened(samples, answers));
    if own.is_empty() {
        return None;
    }
    let beyond = &own - &free * factor(nuisances, &free)?.solve(&free.tr_mul(&own));
    let left = DVector::from_vec(noise.whiten(samples, &fitted.explained.left_m));
    let scores = own.tr_mul(&left);
    let directions = SymmetricEigen::new(own.tr_mul(&beyond));
    let least = LEAST_DIRECTION * directions.eigenvalues.max();
    let (mut explained, mut count) = (0.0, 0.0);
    for (direction, &variance) in directions.eigenvectors.column_iter().zip(&directions.eigenvalues) {
        if variance > least {
            explained += direction.dot(&scores).powi(2) / variance;
            count += 1.0;
        }
    }
    let numbers = left.len() as f64;
    let freedom = numbers - count - free.ncols() as f64;
    let rest = (left.norm_squared() - explained) / freedom;
    (freedom >= 1.0 && rest > 0.0).then(|| Together {
        p_value: f_above(explained / count / rest, count, freedom),
        more_m: ((explained - count * rest).max(0.0) / numbers).sqrt() * noise.rms_m(),
    })
}

/// Of the information on what is free; a size that nothing depends on does no harm.
fn factor(nuisances: &Nuisances, free: &DMatrix<f64>) -> Option<Cholesky<f64, nalgebra::Dyn>> {
    let mut information = nuisances.information(free);
    let largest = information.diagonal().max();
    (0..information.ncols()).for_each(|k| {
        let own = information[(k, k)];
        information[(k, k)] += RIDGE * if own > 0.0 { own } else { largest };
    });
    Cholesky::new(information)
}

/// Without columns that are zero.
fn of_length_one(columns: DMatrix<f64>) -> DMatrix<f64> {
    let kept: Vec<DVector<f64>> =
        columns.column_iter().filter(|column| column.norm() > 0.0).map(|column| column.normalize()).collect();
    DMatrix::from_fn(columns.nrows(), kept.len(), |row, k| kept[k][row])
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::super::samples::white_noise;
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
    fn tested(correlation: f64, each_m: f64, seed: u64) -> Together {
        let (samples, waves) = (Samples::alike(6, 50), waves());
        let (mut noise, mut last) = (white_noise(NOISE_M, seed), [0.0; 3]);
        let mut left_m = Vec::new();
        for sample in &samples.rows {
            let kept = if sample.row == 0 { 0.0 } else { correlation };
            last = last.map(|before| kept * before + (1.0 - kept * kept).sqrt() * noise());
            left_m.extend(last);
        }
        for (left, wave) in left_m.iter_mut().zip(waves.row_iter()) {
            *left += each_m * wave.sum();
        }
        let own = |k: usize| (waves.column(k).as_slice().to_vec(), 1.0);
        let nuisances = Nuisances::independent(900, &[own(0)]);
        let explained = Nuisances::independent(900, &[own(0), own(1)]).explain(&samples, &left_m, 0.0);
        let jacobian = waves.columns(1, 1).into_owned();
        let fitted = Fitted { members: Vec::new(), explained, played: vec![0.0; 900], jacobian };
        together(&samples, &nuisances, &fitted, &waves).unwrap()
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

    #[test]
    fn where_nothing_can_be_explained_nothing_is_said() {
        let (samples, nothing) = (Samples::alike(6, 50), DMatrix::zeros(900, 0));
        let nuisances = Nuisances::independent(900, &[]);
        let mut noise = white_noise(NOISE_M, 0);
        let left_m: Vec<f64> = (0..900).map(|_| noise()).collect();
        let explained = nuisances.explain(&samples, &left_m, 0.0);
        let fitted =
            Fitted { members: Vec::new(), explained, played: vec![0.0; 900], jacobian: DMatrix::zeros(900, 0) };
        assert!(together(&samples, &nuisances, &fitted, &nothing).is_none());
        assert!(together(&samples, &nuisances, &fitted, &DMatrix::zeros(900, 2)).is_none());
        assert!(together(&samples, &nuisances, &fitted, &waves()).is_some_and(|found| found.p_value > 0.01));
    }
}
