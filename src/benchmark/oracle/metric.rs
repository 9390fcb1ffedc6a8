//! Metric of the oracle: squares over the noise, minus what uncertain parameters explain.

use nalgebra::{DMatrix, DVector};

/// Squares over the noise after uncertain parameters explained their part under their priors.
pub(crate) struct Metric<'a> {
    uncertain: &'a [Vec<f64>],
    inverse: DMatrix<f64>,
}

impl Metric<'_> {
    pub(crate) fn new(uncertain: &[Vec<f64>]) -> Metric<'_> {
        let count = uncertain.len();
        let precision =
            DMatrix::from_fn(count, count, |a, b| dot(&uncertain[a], &uncertain[b]) + f64::from(u8::from(a == b)));
        let inverse = precision.try_inverse().unwrap_or_else(|| DMatrix::zeros(count, count));
        Metric { uncertain, inverse }
    }

    pub(crate) fn product(&self, a: &[f64], b: &[f64]) -> f64 {
        let along = |v: &[f64]| DVector::from_iterator(self.uncertain.len(), self.uncertain.iter().map(|u| dot(u, v)));
        dot(a, b) - along(a).dot(&(&self.inverse * along(b)))
    }

    pub(crate) fn square(&self, a: &[f64]) -> f64 {
        self.product(a, a).max(0.0)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
