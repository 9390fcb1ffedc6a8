//! Gram matrix, gradient and derivative images of the likelihood for a kernel expression.

use super::composite::{Composite, PointRun};
use super::likelihood::Likelihood;
use crate::learn::simd::dot;

/// Hyper-parameters from their logarithms.
pub(super) fn natural(theta: &[f64]) -> Vec<f64> {
    theta.iter().map(|t| t.exp()).collect()
}

impl Likelihood<'_> {
    pub(super) fn fill_composite(&mut self, composite: &Composite) {
        let natural = natural(&self.theta);
        let noise = self.covariance.noise_variance(&self.theta);
        for j in 0..self.points.n {
            let at = self.points.point(j);
            let column = self.factor.column_mut(j);
            // From the diagonal down: the Gram matrix is symmetric.
            let run = PointRun { points: self.points, from: j, self_index: Some(0) };
            composite.row(&natural, run, &at, column);
            column[0] += noise;
        }
    }

    /// The gradient from the inverse of the Gram matrix.
    pub(super) fn composite_gradient(&self, composite: &Composite, out: &mut [f64]) {
        let natural = natural(&self.theta);
        let n = self.points.n;
        out.fill(0.0);
        let mut trace = 0.0;
        let mut rates = vec![0.0; n];
        for j in 0..n {
            let inverse = self.inverse.column(j);
            // Half of the diagonal, and each pair off it once: ½ Σ_ij W_ij ∂K_ij.
            let mut w: Vec<f64> =
                self.alpha[j..].iter().zip(inverse).map(|(a, k)| a * self.alpha[j] - k).collect();
            trace += w[0];
            w[0] *= 0.5;
            let row = composite.row_rates(
                &natural,
                PointRun { points: self.points, from: j, self_index: Some(0) },
                &self.points.point(j),
            );
            for (k, out) in out.iter_mut().enumerate().take(composite.len()) {
                composite.rate(&natural, &row, k, &mut rates[..n - j]);
                *out -= dot(&w, &rates[..n - j]);
            }
        }
        out[composite.len()] = -0.5 * self.covariance.noise_variance(&self.theta) * trace;
    }

    /// `∂K/∂θ_k w_p` for every hyper-parameter k and each of `count` probes p: column `k · count +
    /// p` of n numbers.
    pub(super) fn composite_images(
        &self,
        composite: &Composite,
        probes: &[f64],
        count: usize,
    ) -> Vec<f64> {
        let (n, natural) = (self.points.n, natural(&self.theta));
        let noise = self.covariance.noise_variance(&self.theta);
        let mut images = vec![0.0; n * count * (composite.len() + 1)];
        let mut rates = vec![0.0; n];
        for j in 0..n {
            let row = composite.row_rates(
                &natural,
                PointRun { points: self.points, from: 0, self_index: Some(j) },
                &self.points.point(j),
            );
            for k in 0..composite.len() {
                composite.rate(&natural, &row, k, &mut rates);
                for (p, w) in probes.chunks_exact(n).enumerate() {
                    images[(k * count + p) * n + j] = dot(&rates, w);
                }
            }
            for p in 0..count {
                images[(composite.len() * count + p) * n + j] = noise * probes[p * n + j];
            }
        }
        images
    }
}
