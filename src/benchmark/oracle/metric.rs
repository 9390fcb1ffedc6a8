//! Metric of the oracle: squares over the noise, minus what uncertain parameters explain.

use nalgebra::{DMatrix, DVector};

/// Squares over the noise after uncertain parameters explained their part under their priors. With
/// the columns U of the uncertain parameters, scaled to unit priors, the covariance is I + U Uᵀ;
/// its inverse is I − U (I + Uᵀ U)⁻¹ Uᵀ (Woodbury's identity).
pub(crate) struct Metric<'a> {
    uncertain: &'a [Vec<f64>],
    inverse: DMatrix<f64>,
}

impl Metric<'_> {
    pub(crate) fn new(uncertain: &[Vec<f64>]) -> Metric<'_> {
        let count = uncertain.len();
        let precision = DMatrix::from_fn(count, count, |a, b| {
            dot(&uncertain[a], &uncertain[b]) + f64::from(u8::from(a == b))
        });
        let inverse = precision.try_inverse().unwrap_or_else(|| DMatrix::zeros(count, count));
        Metric { uncertain, inverse }
    }

    pub(crate) fn product(&self, a: &[f64], b: &[f64]) -> f64 {
        let projections = |v: &[f64]| {
            DVector::from_iterator(self.uncertain.len(), self.uncertain.iter().map(|u| dot(u, v)))
        };
        dot(a, b) - projections(a).dot(&(&self.inverse * projections(b)))
    }

    pub(crate) fn square(&self, a: &[f64]) -> f64 {
        self.product(a, a).max(0.0)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
