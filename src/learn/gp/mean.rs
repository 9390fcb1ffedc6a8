//! Mean functions: what the process is taken to be before its kernel speaks.
//!
//! The weights of the basis functions have a flat prior and are integrated out (Rasmussen &
//! Williams 2006, section 2.7 with B → ∞): predictions add `h(x)ᵀ β` with `β` of generalised least
//! squares (eq. 2.41), variances what is not known of `β` (eq. 2.42), and hyper-parameters maximise
//! the likelihood without the weights (eq. 2.45), which is that of restricted maximum likelihood.

use serde::{Deserialize, Serialize};

use super::covariance::TrainingPoints;
use crate::learn::simd::dot;

/// Mean function of a Gaussian process, on top of the mean of the training outputs.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum MeanFunction {
    /// None except the mean of the training outputs.
    #[default]
    Zero,
    /// A constant of unknown value.
    Constant,
    /// A constant and a slope along each input, of unknown values.
    Linear,
}

impl MeanFunction {
    /// Whether nothing is added.
    pub fn is_zero(&self) -> bool {
        *self == MeanFunction::Zero
    }

    /// Rows that a process with this mean on so many inputs needs at least: the weights of the
    /// mean, and two for kernel and noise.
    pub fn least_rows(self, inputs: usize) -> usize {
        match self {
            MeanFunction::Zero => 2,
            MeanFunction::Constant => 3,
            MeanFunction::Linear => 3 + inputs,
        }
    }
}

/// Part of a basis function that those before it must leave unexplained, as a share of its size:
/// below it the points do not tell its weight.
const INDEPENDENCE_TOLERANCE: f64 = 1e-6;

/// The basis functions whose weights some points can tell.
#[derive(Clone, Debug, Default)]
pub(super) struct MeanBasis {
    constant: bool,
    /// Inputs with a slope, from 0.
    slopes: Vec<usize>,
}

impl MeanBasis {
    /// The basis of `mean` on `points`: an input that the others determine, or that does not vary,
    /// has no slope of its own.
    pub(super) fn of(mean: MeanFunction, points: &TrainingPoints) -> MeanBasis {
        if mean.is_zero() || points.n == 0 {
            return MeanBasis::default();
        }
        let n = points.n;
        // The constant comes first, so an input that does not vary has no remainder.
        let mut directions = vec![vec![1.0 / (n as f64).sqrt(); n]];
        let inputs = if mean == MeanFunction::Linear { points.inputs } else { 0 };
        let mut slopes = Vec::new();
        for d in 0..inputs {
            let mut remainder = points.input(d).to_vec();
            let size = dot(&remainder, &remainder).sqrt();
            // Gram & Schmidt, twice: once leaves rounding errors as large as the threshold.
            for direction in directions.iter().chain(&directions) {
                let share = dot(direction, &remainder);
                remainder
                    .iter_mut()
                    .zip(direction)
                    .for_each(|(remainder, unit)| *remainder -= share * unit);
            }
            let independent_size = dot(&remainder, &remainder).sqrt();
            if independent_size > INDEPENDENCE_TOLERANCE * size {
                remainder.iter_mut().for_each(|remainder| *remainder /= independent_size);
                directions.push(remainder);
                slopes.push(d);
            }
        }
        MeanBasis { constant: true, slopes }
    }

    /// Number of basis functions.
    pub(super) fn len(&self) -> usize {
        usize::from(self.constant) + self.slopes.len()
    }

    /// Values at the points: one column of n numbers a basis function.
    pub(super) fn columns(&self, points: &TrainingPoints) -> Vec<f64> {
        let mut columns = vec![1.0; if self.constant { points.n } else { 0 }];
        self.slopes.iter().for_each(|&d| columns.extend_from_slice(points.input(d)));
        columns
    }

    /// Values at the point `x`.
    pub(super) fn at(&self, x: &[f64]) -> impl Iterator<Item = f64> {
        let constant = if self.constant { Some(1.0) } else { None };
        constant.into_iter().chain(self.slopes.iter().map(|&d| x[d]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Rows;

    #[test]
    fn inputs_that_others_determine_have_no_slope() {
        let mut rows = Rows::new(5);
        (0..40).map(f64::from).for_each(|i| {
            let (a, b) = ((1.3 * i).sin(), (0.7 * i).cos());
            rows.push(&[a, -a, 3.0, b, 2.0 * a - 0.5 * b + 1.0]);
        });
        let points = TrainingPoints::of(&rows);
        let basis = MeanBasis::of(MeanFunction::Linear, &points);
        assert_eq!((basis.constant, basis.slopes.as_slice(), basis.len()), (true, &[0, 3][..], 3));
        assert_eq!(basis.at(&[1.0, 2.0, 3.0, 4.0, 5.0]).collect::<Vec<f64>>(), [1.0, 1.0, 4.0]);
        assert_eq!(basis.columns(&points).len(), 3 * 40);
        assert_eq!(MeanBasis::of(MeanFunction::Zero, &points).len(), 0);
        assert_eq!(MeanBasis::of(MeanFunction::Constant, &points).len(), 1);
    }
}
