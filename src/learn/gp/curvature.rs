//! Estimate of the likelihood's curvature, for Newton-like first steps of the search.
//!
//! The expected Hessian of `−ln p` is the Fisher information `F_ij = ½ tr(K⁻¹ ∂K/∂θ_i K⁻¹ ∂K/∂θ_j)`
//! (Rasmussen & Williams 2006, section 5.4.1's Hessian in expectation). It is `½ E[(∂K/∂θ_i w)ᵀ K⁻¹
//! (∂K/∂θ_j w)]` for `w` with covariance K⁻¹ (Hutchinson's trace estimator): a few such vectors
//! cost N² each instead of N³. One of them is `α`, which has that covariance if the model is right
//! and makes that term the "average information" of Gilmour, Thompson & Cullis 1995; the others are
//! `L⁻ᵀ z` for fixed vectors `z` of random signs.

use rand::RngExt;

use super::covariance::{Covariance, HyperparameterLayout};
use super::kernels::Kernel;
use super::likelihood::Likelihood;
use crate::base::Seed;
use crate::learn::simd::dot;
use crate::math::vectorised;

/// Vectors in the average.
const PROBES: usize = 8;

impl Likelihood<'_> {
    /// Estimated Fisher information at the latest value, row-major.
    pub(super) fn information(&mut self) -> Vec<f64> {
        let (n, count) = (self.points.n, self.covariance.len());
        // Fixed probes: the same data give the same search.
        let mut rng = Seed(0).child("fisher probes").rng();
        let signs = (0..n * (PROBES - 1)).map(|_| if rng.random::<bool>() { 1.0 } else { -1.0 });
        let mut probes: Vec<f64> = signs.collect();
        // 1. L⁻ᵀ z has the covariance K⁻¹, as α has if the model is right.
        self.factor.solve_transposed_half(&mut probes);
        probes.extend_from_slice(&self.alpha);
        // 2. ∂K/∂θ_k applied to each probe.
        let mut images = match self.covariance.clone() {
            Covariance::Stationary(kernel, layout) => {
                self.stationary_images(kernel, layout, &probes)
            }
            Covariance::Composite(composite) => self.composite_images(&composite, &probes, PROBES),
        };
        // 3. Half of K⁻¹ on each side makes all entries dot products.
        self.factor.solve_half(&mut images);
        let mut out = vec![0.0; count * count];
        for i in 0..count {
            for j in 0..count {
                let image = |k: usize| &images[k * n * PROBES..(k + 1) * n * PROBES];
                let sum = vectorised!(dot(image(i), image(j)));
                out[i * count + j] = 0.5 * sum / PROBES as f64;
            }
        }
        out
    }

    /// `∂K/∂θ_k w_p` for every hyper-parameter k and probe p: column `k · PROBES + p` of n numbers.
    fn stationary_images(
        &self,
        kernel: &dyn Kernel,
        layout: HyperparameterLayout,
        probes: &[f64],
    ) -> Vec<f64> {
        let n = self.points.n;
        let theta = &self.theta;
        let (shape, signal) = (layout.shape(theta), layout.signal_variance(theta));
        let noise = layout.noise_variance(theta);
        let mut images = vec![0.0; n * PROBES * layout.len()];
        let (mut s, mut slope, mut row) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        for j in 0..n {
            let mut add = |k: usize, factor: f64, row: &[f64]| {
                vectorised!({
                    for (p, w) in probes.chunks_exact(n).enumerate() {
                        images[(k * PROBES + p) * n + j] += factor * dot(row, w);
                    }
                });
            };
            self.scaled.squared_distances(0, |d| self.scaled.input(d)[j], &mut s);
            for k in 0..layout.shapes {
                row.copy_from_slice(&s);
                kernel.shape_slopes(&shape, k, &mut row);
                add(1 + layout.lengths + k, signal, &row);
            }
            kernel.slopes(&shape, &mut s, &mut slope);
            add(0, signal, &s);
            for d in 0..layout.inputs {
                let (x, centre) = (self.scaled.input(d), self.scaled.input(d)[j]);
                vectorised!({
                    for ((row, x), slope) in row.iter_mut().zip(x).zip(&slope) {
                        *row = (x - centre) * (x - centre) * slope;
                    }
                });
                add(1 + d.min(layout.lengths - 1), -2.0 * signal, &row);
            }
            for p in 0..PROBES {
                images[((layout.len() - 1) * PROBES + p) * n + j] = noise * probes[p * n + j];
            }
        }
        images
    }
}
