//! The gradient of the sparse likelihoods.
//!
//! With `P = (Q + Λ)⁻¹` (the weights of the mean function projected out), `α = P y` and `W = α αᵀ −
//! P`, the likelihood changes by `½ tr(W dQ) + ½ Σ W_ii dΛ_ii`. Because `Q = K_fu K_uu⁻¹ K_uf`, and
//! because Λ (FITC) or the part that the bound subtracts (SGPR) holds the diagonal of Q as well,
//! all is a sum of `G = W̃ K_fu K_uu⁻¹` against `dK_fu`, of `−½ K_uu⁻¹ K_uf W̃ K_fu K_uu⁻¹` against
//! `dK_uu`, and of weights against the variances, with `W̃ = W + diag(d)`.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

use super::rates::CovarianceAt;
use super::{JITTER, SparseLikelihood};
use crate::learn::gp::config::Approximation;
use crate::learn::gp::linear::Lower;

/// Weights of the diagonals in the gradient.
struct DiagonalWeights {
    /// d: what W̃ has more than W.
    added: Vec<f64>,
    /// Of the variances `k_ii`.
    variances: Vec<f64>,
    /// Of the noise in Λ.
    noises: Vec<f64>,
}

impl SparseLikelihood<'_> {
    /// Writes the gradient of minus the likelihood at the latest value.
    pub(super) fn gradient_into(&mut self, out: &mut [f64]) {
        let (n, m, width) = (self.points.n, self.inducing.n, self.width());
        // 1. S⁻¹ and P V.
        let inverse = self.precision_inverse();
        let projected = self.projected(&inverse);
        // 2. The diagonals of W̃, of the variances and of the noise.
        let weights = self.diagonal_weights(&projected);
        // 3. G = W̃ Vᵀ L⁻¹ against dK_fu.
        let mut crossed = projected;
        crossed.truncate(n * m);
        for (j, column) in crossed.chunks_exact_mut(n).enumerate() {
            let (weight, v) = (self.weights[j], &self.features[j * n..(j + 1) * n]);
            for (i, value) in column.iter_mut().enumerate() {
                *value = self.alpha[i] * weight - *value + weights.added[i] * v[i];
            }
        }
        // 4. −½ L⁻ᵀ V W̃ Vᵀ L⁻¹ against dK_uu.
        let mut inner = self.inner_weights(&inverse, &weights, width);
        self.inducing_factor.solve_transposed_half_rows(&mut crossed);
        self.inducing_factor.solve_transposed_half(&mut inner);
        self.inducing_factor.solve_transposed_half_rows(&mut inner);
        self.sum_rates(&mut crossed, &inner, &weights, out);
    }

    /// S⁻¹, full.
    fn precision_inverse(&mut self) -> Vec<f64> {
        let width = self.width();
        let mut lower = Lower::zeros(width);
        self.precision_factor.inverse(&mut lower, &mut self.memory[1]);
        let mut full = vec![0.0; width * width];
        for j in 0..width {
            for (i, value) in lower.column(j).iter().enumerate().map(|(i, value)| (j + i, *value)) {
                full[j * width + i] = value;
                full[i * width + j] = value;
            }
        }
        full
    }

    /// `Λ⁻¹ Φᵀ S⁻¹`: N rows, a column a feature; `P V = ` its first m columns.
    fn projected(&self, inverse: &[f64]) -> Vec<f64> {
        let (n, width) = (self.points.n, self.width());
        let mut out = vec![0.0; n * width];
        matmul(
            MatMut::from_column_major_slice_mut(&mut out, n, width),
            Accum::Replace,
            MatRef::from_column_major_slice(&self.weighted, n, width),
            MatRef::from_column_major_slice(inverse, width, width),
            1.0,
            Par::Seq,
        );
        let roots: Vec<f64> = self.diagonal.iter().map(|variance| 1.0 / variance.sqrt()).collect();
        for column in out.chunks_exact_mut(n) {
            column.iter_mut().zip(&roots).for_each(|(value, root)| *value *= root);
        }
        out
    }

    fn diagonal_weights(&self, projected: &[f64]) -> DiagonalWeights {
        let n = self.points.n;
        // W_ii = α_i² − P_ii with P_ii = 1/Λ_i − φ_iᵀ S⁻¹ φ_i / Λ_i².
        let mut rate: Vec<f64> = vec![0.0; n];
        for (feature, projected) in self.features.chunks_exact(n).zip(projected.chunks_exact(n)) {
            rate.iter_mut().zip(feature).zip(projected).for_each(|((rate, a), b)| *rate += a * b);
        }
        for (i, rate) in rate.iter_mut().enumerate() {
            *rate = self.alpha[i] * self.alpha[i] - (1.0 - *rate) / self.diagonal[i];
        }
        let half: Vec<f64> = rate.iter().map(|rate| 0.5 * rate).collect();
        if self.approximation == Approximation::Fitc {
            // Λ holds k_ii − Q_ii: its part of Q cancels the diagonal of W.
            let added = rate.iter().map(|rate| -rate).collect();
            return DiagonalWeights { added, variances: half.clone(), noises: half };
        }
        // From the trace term ½ Σ (k_ii − Q_ii)/Λ_ii that the bound subtracts.
        let added: Vec<f64> = self.diagonal.iter().map(|variance| 1.0 / variance).collect();
        let variances = added.iter().map(|added| -0.5 * added).collect();
        let noise_of_trace = |i: usize| 0.5 * self.missing[i] * added[i] * added[i];
        let noises = half.iter().enumerate().map(|(i, half)| half + noise_of_trace(i)).collect();
        DiagonalWeights { added, variances, noises }
    }

    /// `V W̃ Vᵀ`, m × m.
    fn inner_weights(&self, inverse: &[f64], weights: &DiagonalWeights, width: usize) -> Vec<f64> {
        let (n, m) = (self.points.n, self.inducing.n);
        let mut inner = vec![0.0; m * m];
        if self.approximation == Approximation::Fitc {
            let features = MatRef::from_column_major_slice(&self.features[..n * m], n, m);
            let mut scaled = self.features[..n * m].to_vec();
            for column in scaled.chunks_exact_mut(n) {
                column.iter_mut().zip(&weights.added).for_each(|(value, added)| *value *= added);
            }
            let scaled = MatRef::from_column_major_slice(&scaled, n, m);
            let out = MatMut::from_column_major_slice_mut(&mut inner, m, m);
            matmul(out, Accum::Replace, features.transpose(), scaled, 1.0, Par::Seq);
        }
        for j in 0..m {
            for i in 0..m {
                let (low, high) = (i.max(j), i.min(j));
                // V P Vᵀ = 1 − S⁻¹ and, for SGPR, V diag(d) Vᵀ = S − 1.
                let identity = f64::from(u8::from(i == j));
                let noise = match self.approximation {
                    Approximation::Fitc => 0.0,
                    _ => self.precision.column(high)[low - high] - identity,
                };
                inner[j * m + i] +=
                    self.weights[i] * self.weights[j] - identity + inverse[j * width + i] + noise;
            }
        }
        inner
    }

    fn sum_rates(
        &self,
        crossed: &mut [f64],
        inner: &[f64],
        weights: &DiagonalWeights,
        out: &mut [f64],
    ) {
        let (n, m) = (self.points.n, self.inducing.n);
        let at = CovarianceAt::new(&self.covariance, &self.theta);
        let (all, inducing) = (at.prepare(self.points), at.prepare(&self.inducing));
        out.fill(0.0);
        for j in 0..m {
            let centre = inducing.point(j);
            at.add_row_rates(&all, 0, &centre, &mut crossed[j * n..(j + 1) * n], out);
            // Each pair off the diagonal once, so without the factor ½.
            let mut column: Vec<f64> =
                inner[j * m + j..(j + 1) * m].iter().map(|weight| -weight).collect();
            column[0] *= 0.5 * (1.0 + JITTER);
            at.add_row_rates(&inducing, j, &centre, &mut column, out);
        }
        at.add_diagonal_rates(self.points, &weights.variances, &weights.noises, out);
        let noise = out.len() - 1;
        out[noise] = self.noise_variance() * weights.noises.iter().sum::<f64>();
        out.iter_mut().for_each(|rate| *rate = -*rate);
    }
}
