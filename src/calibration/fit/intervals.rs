//! Intervals of the fitted numbers, what is not determined, and which numbers trade against each
//! other.

use nalgebra::{DMatrix, DVector};

use super::optimum::{CalibrationProblem, Optimum};
use crate::calibration::compare::robust::ErrorLaw;
use crate::math::distribution::student_95;

/// Directions whose eigenvalue is below this share of the largest (coordinates scaled to unit
/// curvature) are not identifiable.
const UNSEEN_DIRECTION: f64 = 1e-12;
/// A number with more than this share in an unidentifiable direction has no interval.
const UNSEEN_SHARE: f64 = 1e-4;
/// Least number of blocks for a covariance between blocks.
const MIN_BLOCKS: usize = 5;

/// Uncertainty of the coordinates at an optimum.
#[derive(Clone, Debug)]
pub(crate) struct Uncertain {
    /// Half width of the 95 % interval of each coordinate; infinite where it is not determined.
    pub(crate) half: Vec<f64>,
    /// Correlation of the coordinates; zero for those that are not determined.
    pub(crate) correlation: DMatrix<f64>,
    /// Whether the covariance between blocks widened the intervals.
    pub(crate) widened: bool,
}

/// The uncertainty at `best`. `blocks` (one of each sighting) is given where the model errs by more
/// than noise: errors within a block may then be correlated in any way, and the covariance is at
/// least the sandwich of the blocks' scores (Liang & Zeger 1986), with the correction (G/(G−1)) and
/// Student's t with G − 1 degrees of freedom for G blocks.
pub(crate) fn uncertainty(
    problem: &CalibrationProblem,
    best: &Optimum,
    blocks: Option<&[usize]>,
) -> Uncertain {
    let count = best.x.len();
    let (normal, _) = problem.normal(best);
    let Some(Inverse { inverse, determined }) = inverse(&normal) else {
        let correlation = DMatrix::identity(count, count);
        return Uncertain { half: vec![f64::INFINITY; count], correlation, widened: false };
    };
    let data = 3.0 * best.positions.iter().filter(|at| at.is_some()).count() as f64;
    let freedom = data - determined.iter().filter(|&&seen| seen).count() as f64;
    // 1. As if all errors were independent.
    let mut covariance = classical(problem, best, &inverse);
    let mut half: Vec<f64> =
        (0..count).map(|k| student_95(freedom.max(1.0)) * covariance[(k, k)].sqrt()).collect();
    // 2. Where the model errs, at least the scatter between blocks.
    let between = blocks.and_then(|blocks| sandwich(best, &inverse, blocks));
    let mut widened = false;
    if let Some((wide, freedom)) = between {
        let quantile = student_95(freedom);
        for (k, half) in half.iter_mut().enumerate() {
            let sandwich_half = quantile * wide[(k, k)].sqrt();
            widened |= sandwich_half > *half;
            *half = half.max(sandwich_half);
        }
        if widened {
            covariance = wide;
        }
    }
    let size = |k: usize| covariance[(k, k)].sqrt().max(f64::MIN_POSITIVE);
    // 3. Correlations show which numbers trade against each other.
    let correlation =
        DMatrix::from_fn(count, count, |a, b| match (a == b, determined[a] && determined[b]) {
            (true, _) => 1.0,
            (false, true) => (covariance[(a, b)] / (size(a) * size(b))).clamp(-1.0, 1.0),
            (false, false) => 0.0,
        });
    half.iter_mut()
        .zip(&determined)
        .filter(|(_, seen)| !**seen)
        .for_each(|(half, _)| *half = f64::INFINITY);
    Uncertain { half, correlation, widened }
}

/// Covariance for independent errors: s² (JᵀJ)⁻¹, for Student's t with the factor (ν + 5)/(ν + 3)
/// of its information in three coordinates (Lange, Little & Taylor 1989).
fn classical(problem: &CalibrationProblem, best: &Optimum, inverse: &DMatrix<f64>) -> DMatrix<f64> {
    let factor = if problem.likelihood == ErrorLaw::StudentT { 9.0 / 7.0 } else { 1.0 };
    inverse * (factor * best.variance_m2)
}

/// Covariance from the scatter of the blocks' scores, and its degrees of freedom; `None` for too
/// few blocks.
fn sandwich(
    best: &Optimum,
    inverse: &DMatrix<f64>,
    blocks: &[usize],
) -> Option<(DMatrix<f64>, f64)> {
    let count = best.x.len();
    let number = blocks.iter().max().map_or(0, |last| last + 1);
    let mut scores = DMatrix::<f64>::zeros(count, number);
    for (index, &block) in blocks.iter().enumerate() {
        let rows = best.slopes.rows(3 * index, 3);
        let score: DVector<f64> =
            rows.tr_mul(&best.residual_m.rows(3 * index, 3)) * best.weights[index];
        let mut column = scores.column_mut(block);
        column += score;
    }
    if number < MIN_BLOCKS {
        return None;
    }
    // Sandwich: (JᵀWJ)⁻¹ (Σ s_g s_gᵀ) (JᵀWJ)⁻¹, with G/(G − 1) for few blocks.
    let middle = &scores * scores.transpose() * (number as f64 / (number as f64 - 1.0));
    Some((inverse * middle * inverse, number as f64 - 1.0))
}

/// Pseudo-inverse of a normal matrix, and which coordinates it determines.
pub(crate) struct Inverse {
    pub(crate) inverse: DMatrix<f64>,
    pub(crate) determined: Vec<bool>,
}

/// The inverse of a normal matrix on the directions that the data determine; `None` when there is
/// none.
pub(crate) fn inverse(normal: &DMatrix<f64>) -> Option<Inverse> {
    let count = normal.nrows();
    let size: Vec<f64> = (0..count).map(|k| normal[(k, k)].max(0.0).sqrt()).collect();
    let seen: Vec<usize> = (0..count).filter(|&k| size[k] > 0.0).collect();
    if seen.is_empty() {
        return None;
    }
    // Unit diagonal, so that eigenvalues do not depend on the units of the numbers.
    let scaled = DMatrix::from_fn(seen.len(), seen.len(), |a, b| {
        normal[(seen[a], seen[b])] / (size[seen[a]] * size[seen[b]])
    });
    let parts = scaled.symmetric_eigen();
    let smallest = UNSEEN_DIRECTION * parts.eigenvalues.max();
    let mut inverse = DMatrix::zeros(count, count);
    let mut determined = vec![false; count];
    seen.iter().for_each(|&k| determined[k] = true);
    for (direction, &value) in parts.eigenvectors.column_iter().zip(parts.eigenvalues.iter()) {
        for (a, &row) in seen.iter().enumerate() {
            if value <= smallest {
                // The pseudo-inverse leaves this direction out; numbers in it have no interval.
                determined[row] &= direction[a].abs() <= UNSEEN_SHARE;
                continue;
            }
            for (b, &column) in seen.iter().enumerate() {
                inverse[(row, column)] +=
                    direction[a] * direction[b] / (value * size[row] * size[column]);
            }
        }
    }
    Some(Inverse { inverse, determined })
}
