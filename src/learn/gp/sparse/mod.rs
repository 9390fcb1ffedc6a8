//! Sparse Gaussian processes with inducing points, for more samples than an exact process can take.
//!
//! With `m` inducing points u among the N samples f, `K_uu = L Lᵀ`, `V = L⁻¹ K_uf` and `Q = Vᵀ V`,
//! the samples are taken to have the covariance `Q + Λ` with a diagonal Λ:
//!
//! - `sgpr`: Λ is the noise; from the log likelihood `½ Σ (k_ii − Q_ii)/Λ_ii` is subtracted, which
//!   makes it a lower bound of the exact one (Titsias 2009, eq. 9).
//! - `fitc`: Λ is the noise and `diag(K − Q)` (Snelson & Ghahramani 2006; Quiñonero-Candela &
//!   Rasmussen 2005, eq. 24).
//!
//! Both are linear regressions on the features `φ_i = (V_i, h(x_i))`, whose weights have the prior
//! precision `D`: 1 for each inducing point and 0 for each basis function h of the mean. So `S =
//! D + Φ Λ⁻¹ Φᵀ` gives likelihood, weights and variances. Noise that a kernel expression has of its
//! own (`white`) belongs to Λ.

mod conditioned;
mod gradient;
mod held_out;
mod inducing;
mod rates;
mod search;

pub(super) use inducing::greedy_conditional_variance;
pub(super) use rates::CovarianceAt;
pub(super) use search::search;

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, MatRef, Par};

use super::config::Approximation;
use super::coordinates::LogLikelihood;
use super::covariance::{Covariance, TrainingPoints};
use super::linear::{FactorBuffers, Lower};
use super::mean::{MeanBasis, MeanFunction};
use crate::learn::simd::dot;
use crate::math::optimise::Objective;

/// Relative growth of the diagonal of `K_uu`: it stays positive definite when length-scales grow
/// during a search.
const JITTER: f64 = 1e-10;

/// Minus the log marginal likelihood (FITC) or its lower bound (SGPR) of one standardised output as
/// a function of the logarithmic hyper-parameters.
pub(super) struct SparseLikelihood<'a> {
    approximation: Approximation,
    covariance: Covariance,
    points: &'a TrainingPoints,
    y: &'a [f64],
    inducing: TrainingPoints,
    basis: MeanBasis,
    theta: Vec<f64>,
    /// Φᵀ: N rows, a column a feature; V before H.
    features: Vec<f64>,
    /// Λ^−½ Φᵀ.
    weighted: Vec<f64>,
    /// Cholesky factor of `K_uu`.
    inducing_factor: Lower,
    /// S and its Cholesky factor.
    precision: Lower,
    precision_factor: Lower,
    /// Λ, and `k_ii − Q_ii`.
    diagonal: Vec<f64>,
    missing: Vec<f64>,
    /// Weights of the features, and `(Q + Λ)⁻¹ (y − Hᵀβ)`.
    weights: Vec<f64>,
    alpha: Vec<f64>,
    /// First estimate of the curvature of the likelihood, row-major.
    information: Vec<f64>,
    memory: [FactorBuffers; 2],
}

impl<'a> SparseLikelihood<'a> {
    /// With the points numbered `inducing` as inducing points.
    pub(super) fn new(
        approximation: Approximation,
        mean: MeanFunction,
        covariance: Covariance,
        points: &'a TrainingPoints,
        y: &'a [f64],
        inducing: &[usize],
    ) -> Self {
        let basis = MeanBasis::of(mean, points);
        let (n, m) = (points.n, inducing.len());
        let width = m + basis.len();
        let mut features = vec![0.0; n * m];
        features.extend(basis.columns(points));
        SparseLikelihood {
            approximation,
            covariance,
            points,
            y,
            inducing: points.select(inducing),
            basis,
            theta: Vec::new(),
            weighted: features.clone(),
            features,
            inducing_factor: Lower::zeros(m),
            precision: Lower::zeros(width),
            precision_factor: Lower::zeros(width),
            diagonal: vec![0.0; n],
            missing: vec![0.0; n],
            weights: vec![0.0; width],
            alpha: vec![0.0; n],
            information: Vec::new(),
            memory: [m, width].map(FactorBuffers::new),
        }
    }

    /// Number of features.
    fn width(&self) -> usize {
        self.weights.len()
    }

    fn noise_variance(&self) -> f64 {
        self.covariance.noise_variance(&self.theta)
    }

    /// Fills V, Λ and the missing variances; false when `K_uu` is not positive definite.
    fn fill(&mut self) -> bool {
        let (n, m) = (self.points.n, self.inducing.n);
        let at = CovarianceAt::new(&self.covariance, &self.theta);
        let (all, inducing) = (at.prepare(self.points), at.prepare(&self.inducing));
        for j in 0..m {
            let centre = inducing.point(j);
            let column = self.inducing_factor.column_mut(j);
            at.row(&inducing, j, &centre, column);
            // Relative, so that it means the same at any signal variance.
            column[0] *= 1.0 + JITTER;
            at.row(&all, 0, &centre, &mut self.features[j * n..(j + 1) * n]);
        }
        if !self.inducing_factor.factor(&mut self.memory[0]) {
            return false;
        }
        self.inducing_factor.solve_half_rows(&mut self.features[..n * m]);
        at.diagonal(self.points, &mut self.missing, &mut self.diagonal);
        let noise = self.noise_variance();
        self.diagonal.iter_mut().for_each(|diagonal| *diagonal += noise);
        for column in self.features[..n * m].chunks_exact(n) {
            self.missing.iter_mut().zip(column).for_each(|(missing, v)| *missing -= v * v);
        }
        // FITC adds what the inducing points do not explain to the noise; SGPR charges for it in
        // `value`.
        if self.approximation == Approximation::Fitc {
            self.diagonal
                .iter_mut()
                .zip(&self.missing)
                .for_each(|(diagonal, missing)| *diagonal += missing.max(0.0));
        }
        self.diagonal.iter().all(|diagonal| *diagonal > 0.0)
    }

    /// Fills S and its factor; false when it is not positive definite.
    fn fill_precision(&mut self) -> bool {
        let (n, m, width) = (self.points.n, self.inducing.n, self.width());
        let roots: Vec<f64> = self.diagonal.iter().map(|diagonal| 1.0 / diagonal.sqrt()).collect();
        for (weighted, column) in
            self.weighted.chunks_exact_mut(n).zip(self.features.chunks_exact(n))
        {
            weighted
                .iter_mut()
                .zip(column)
                .zip(&roots)
                .for_each(|((to, from), root)| *to = from * root);
        }
        let weighted = MatRef::from_column_major_slice(&self.weighted, n, width);
        matmul(
            self.precision.view_mut(),
            BlockStructure::TriangularLower,
            Accum::Replace,
            weighted.transpose(),
            BlockStructure::Rectangular,
            weighted,
            BlockStructure::Rectangular,
            1.0,
            Par::Seq,
        );
        // The prior precision D: 1 for each inducing point; the basis of the mean has a flat prior.
        (0..m).for_each(|j| self.precision.column_mut(j)[0] += 1.0);
        self.precision_factor.clone_from(&self.precision);
        self.precision_factor.factor(&mut self.memory[1])
    }

    /// Fills the weights of the features and `alpha`.
    fn regress(&mut self) {
        let n = self.points.n;
        let scaled: Vec<f64> =
            self.y.iter().zip(&self.diagonal).map(|(y, diagonal)| y / diagonal).collect();
        let columns = self.features.chunks_exact(n);
        self.weights
            .iter_mut()
            .zip(columns)
            .for_each(|(weight, column)| *weight = dot(column, &scaled));
        self.precision_factor.solve(&mut self.weights, &mut self.memory[1]);
        self.alpha.copy_from_slice(self.y);
        for (weight, column) in self.weights.iter().zip(self.features.chunks_exact(n)) {
            self.alpha
                .iter_mut()
                .zip(column)
                .for_each(|(alpha, feature)| *alpha -= weight * feature);
        }
        self.alpha.iter_mut().zip(&self.diagonal).for_each(|(alpha, diagonal)| *alpha /= diagonal);
    }
}

impl Objective for SparseLikelihood<'_> {
    fn value(&mut self, theta: &[f64]) -> f64 {
        if theta.iter().any(|t| !t.is_finite()) {
            return f64::INFINITY;
        }
        self.theta = theta.to_vec();
        if !self.fill() || !self.fill_precision() {
            return f64::INFINITY;
        }
        self.regress();
        let (n, m) = (self.points.n, self.inducing.n);
        // yᵀ (Q + Λ)⁻¹ y as residuals and weights: no difference of large numbers.
        let residuals: f64 = self
            .alpha
            .iter()
            .zip(&self.diagonal)
            .map(|(alpha, diagonal)| alpha * alpha * diagonal)
            .sum();
        let weights: f64 = self.weights[..m].iter().map(|weight| weight * weight).sum();
        let logarithms: f64 = self.diagonal.iter().map(|diagonal| diagonal.ln()).sum();
        // Each weight of the mean that was integrated out takes a degree of freedom.
        let degrees = (n - self.basis.len()) as f64;
        let normalisation = degrees * (2.0 * std::f64::consts::PI).ln();
        let likelihood = 0.5 * (residuals + weights + logarithms + normalisation)
            + self.precision_factor.half_log_determinant();
        if self.approximation == Approximation::Fitc {
            return likelihood;
        }
        // The trace term of the variational bound of SGPR.
        let trace_term: f64 = self
            .missing
            .iter()
            .zip(&self.diagonal)
            .map(|(missing, diagonal)| missing / diagonal)
            .sum();
        likelihood + 0.5 * trace_term
    }

    fn gradient(&mut self, out: &mut [f64]) {
        self.gradient_into(out);
    }
}

impl LogLikelihood for SparseLikelihood<'_> {
    fn covariance(&self) -> &Covariance {
        &self.covariance
    }

    fn information(&mut self) -> Option<Vec<f64>> {
        (!self.information.is_empty()).then(|| self.information.clone())
    }
}

#[cfg(test)]
mod tests;
