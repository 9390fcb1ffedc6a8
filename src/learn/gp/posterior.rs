//! Mean and variance of one output at new points: paper eq. 19; Rasmussen & Williams 2006,
//! algorithm 2.1.

use std::sync::Arc;

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

use super::composite::{Composite, PointRun};
use super::composite_likelihood::natural;
use super::covariance::{Covariance, TrainingPoints};
use super::kernels::Kernel;
use super::likelihood::Likelihood;
use super::linear::{FactorBuffers, Lower};
use super::mean::{MeanBasis, MeanFunction};
use crate::learn::simd::dot;
use crate::math::optimise::Objective;
use crate::math::vectorised;

/// Queries that a batch handles at once: their covariances with all points stay in cache.
pub(super) const BLOCK: usize = 512;

/// Rows of `L⁻¹` that are multiplied at once, up to the diagonal: the zeros beyond it cost less
/// than a triangular product's small parts.
const PANEL: usize = 48;

/// One fitted output in standardised units.
#[derive(Clone)]
pub(super) struct Posterior {
    pub(super) prior: FittedPrior,
    pub(super) inputs: usize,
    pub(super) alpha: Vec<f64>,
    pub(super) inverse_factor: Lower,
    pub(super) log_marginal_likelihood: f64,
    pub(super) added: Option<AddedTerm>,
    /// Numbers of the samples that are inducing points; none for an exact process.
    pub(super) inducing: Vec<usize>,
}

/// What a mean function or inducing points add to the zero-mean process on its points: `hᵀβ` to the
/// mean, and to the variance `‖E (v, h)‖²` with `v = L⁻¹ k` and the values h of the basis
/// functions.
#[derive(Clone)]
pub(super) struct AddedTerm {
    pub(super) basis: MeanBasis,
    /// β.
    pub(super) weights: Vec<f64>,
    /// E, row after row.
    pub(super) rows: Vec<f64>,
}

/// What the posterior covariance of a point with others is made of: see [`Posterior::features`].
#[derive(Clone)]
pub(super) struct PosteriorFeatures {
    /// v.
    pub(super) projection: Vec<f64>,
    /// `E (v, h)`.
    pub(super) image: Vec<f64>,
}

impl AddedTerm {
    fn mean(&self, x: &[f64]) -> f64 {
        self.basis.at(x).zip(&self.weights).map(|(value, weight)| value * weight).sum()
    }

    /// `E (v, h)`; `scaled` is v over `scale`.
    fn image(&self, x: &[f64], scaled: &[f64], scale: f64) -> Vec<f64> {
        let (n, values) = (scaled.len(), self.basis.at(x).collect::<Vec<f64>>());
        let row =
            |row: &[f64]| vectorised!(scale * dot(&row[..n], scaled) + dot(&row[n..], &values));
        self.rows.chunks_exact(n + values.len()).map(row).collect()
    }

    fn variance(&self, x: &[f64], scaled: &[f64], scale: f64) -> f64 {
        self.image(x, scaled, scale).iter().map(|part| part * part).sum()
    }
}

/// The covariance function under the fitted hyper-parameters, with the training points.
#[derive(Clone)]
pub(super) enum FittedPrior {
    /// One stationary kernel: signal variance apart, points over length-scales.
    Stationary {
        kernel: &'static dyn Kernel,
        shape: Vec<f64>,
        signal: f64,
        length_scales: Vec<f64>,
        scaled: TrainingPoints,
    },
    /// An expression, its hyper-parameters, and the points.
    Composite { composite: Arc<Composite>, natural: Vec<f64>, points: TrainingPoints },
}

impl FittedPrior {
    pub(super) fn new(covariance: &Covariance, theta: &[f64], points: &TrainingPoints) -> Self {
        match covariance {
            Covariance::Stationary(kernel, layout) => FittedPrior::Stationary {
                kernel: *kernel,
                shape: layout.shape(theta),
                signal: layout.signal_variance(theta),
                length_scales: layout.length_scales(theta),
                scaled: points.scaled(&layout.length_scales(theta)),
            },
            Covariance::Composite(composite) => FittedPrior::Composite {
                composite: Arc::clone(composite),
                natural: natural(theta),
                points: points.clone(),
            },
        }
    }

    /// Writes the covariances of the standardised query `x` with all points, over
    /// [`FittedPrior::scale`].
    pub(super) fn covariances(&self, x: &[f64], k: &mut [f64]) {
        match self {
            FittedPrior::Stationary { kernel, shape, length_scales, scaled, .. } => {
                scaled.squared_distances(0, |d| x[d] / length_scales[d], k);
                kernel.correlations(shape, k);
            }
            FittedPrior::Composite { composite, natural, points } => {
                composite.row(natural, PointRun { points, from: 0, self_index: None }, x, k)
            }
        }
    }

    pub(super) fn scale(&self) -> f64 {
        match self {
            FittedPrior::Stationary { signal, .. } => *signal,
            FittedPrior::Composite { .. } => 1.0,
        }
    }

    /// Variance at `x` before any sample.
    pub(super) fn variance(&self, x: &[f64]) -> f64 {
        match self {
            FittedPrior::Stationary { signal, .. } => *signal,
            FittedPrior::Composite { composite, natural, .. } => composite.variance(natural, x),
        }
    }
}

impl Posterior {
    /// Conditions an exact process on the points; `None` when the covariance matrix is not positive
    /// definite.
    pub(super) fn exact(
        covariance: &Covariance,
        mean: MeanFunction,
        points: &TrainingPoints,
        y: &[f64],
        theta: &[f64],
    ) -> Option<Self> {
        let mut likelihood = Likelihood::new(covariance.clone(), mean, points, y);
        let value = likelihood.value(theta);
        value.is_finite().then(|| Posterior {
            prior: FittedPrior::new(covariance, theta, points),
            inputs: points.inputs,
            alpha: likelihood.alpha.clone(),
            inverse_factor: likelihood.factor.inverse_factor(),
            log_marginal_likelihood: -value,
            added: likelihood.added(),
            inducing: Vec::new(),
        })
    }

    /// Number of points that a prediction compares with: samples, or inducing points.
    pub(super) fn points(&self) -> usize {
        self.alpha.len()
    }

    /// Posterior mean; `k` is room for one number per point.
    pub(super) fn mean(&self, x: &[f64], k: &mut [f64]) -> f64 {
        self.prior.covariances(x, k);
        let scale = self.prior.scale();
        let mean = vectorised!(scale * dot(k, &self.alpha));
        self.added.as_ref().map_or(mean, |added| mean + added.mean(x))
    }

    /// Posterior mean and latent (noise-free) variance: `k(x,x) − ‖L⁻¹ k‖²`.
    pub(super) fn mean_variance(&self, x: &[f64], k: &mut [f64], v: &mut [f64]) -> (f64, f64) {
        let mean = self.mean(x, k);
        let explained = vectorised!({
            v.fill(0.0);
            // Four columns at once, because v is read and written for each.
            let (panels, tail) = k.as_chunks::<4>();
            for (p, k) in panels.iter().enumerate() {
                let [a, b, c, d] = self.inverse_factor.panel(4 * p);
                for ((((v, a), b), c), d) in v[4 * p..].iter_mut().zip(a).zip(b).zip(c).zip(d) {
                    *v = k[0].mul_add(*a, k[1].mul_add(*b, k[2].mul_add(*c, k[3].mul_add(*d, *v))));
                }
            }
            let tail_start = k.len() - tail.len();
            for (j, &k) in tail.iter().enumerate().map(|(j, k)| (tail_start + j, k)) {
                for (v, l) in v[j..].iter_mut().zip(self.inverse_factor.column(j)) {
                    *v = k.mul_add(*l, *v);
                }
            }
            dot(v, v)
        });
        (mean, self.variance(x, v, explained))
    }

    /// `v` and `E (v, h)` at the standardised point `x`: the posterior covariance of two points is
    /// that before any sample, less the product of their `v`, plus that of their `E (v, h)`.
    pub(super) fn features(&self, x: &[f64]) -> PosteriorFeatures {
        let (mut k, mut v) = (vec![0.0; self.points()], vec![0.0; self.points()]);
        self.mean_variance(x, &mut k, &mut v);
        let scale = self.prior.scale();
        let image = self.added.as_ref().map_or_else(Vec::new, |added| added.image(x, &v, scale));
        v.iter_mut().for_each(|v| *v *= scale);
        PosteriorFeatures { projection: v, image }
    }

    /// Variance at `x` when the points explain `explained` of it, which is `‖v‖²`; both over the
    /// prior's scale.
    fn variance(&self, x: &[f64], v: &[f64], explained: f64) -> f64 {
        let scale = self.prior.scale();
        let remaining = self.prior.variance(x) - scale * scale * explained;
        self.added
            .as_ref()
            .map_or(remaining, |added| remaining + added.variance(x, v, scale))
            .max(0.0)
    }

    /// [`Posterior::mean_variance`] of up to [`BLOCK`] standardised queries, by products of panels
    /// of `L⁻¹`; `k` and `v` are room for `BLOCK` numbers per point.
    pub(super) fn block(
        &self,
        queries: &[f64],
        k: &mut [f64],
        v: &mut [f64],
        mut put: impl FnMut(usize, f64, f64),
    ) {
        let n = self.alpha.len();
        let count = queries.len() / self.inputs;
        // 1. Covariances and means, query by query.
        let mut means = [0.0; BLOCK];
        for (q, x) in queries.chunks_exact(self.inputs).enumerate() {
            means[q] = self.mean(x, &mut k[q * n..(q + 1) * n]);
        }
        let right = MatRef::from_column_major_slice(&k[..n * count], n, count);
        let mut out = MatMut::from_column_major_slice_mut(&mut v[..n * count], n, count);
        // 2. v = L⁻¹ k for all queries, a panel of rows at a time.
        for from in (0..n).step_by(PANEL) {
            let to = n.min(from + PANEL);
            let left = self.inverse_factor.view().submatrix(from, 0, to - from, to);
            let panel = out.as_mut().subrows_mut(from, to - from);
            matmul(panel, Accum::Replace, left, right.subrows(0, to), 1.0, Par::Seq);
        }
        for q in 0..count {
            let column = &v[q * n..(q + 1) * n];
            let explained = vectorised!(dot(column, column));
            let x = &queries[q * self.inputs..(q + 1) * self.inputs];
            put(q, means[q], self.variance(x, column, explained));
        }
    }

    /// Prediction errors (standardised) of the rows numbered `fold` when they are held out: with
    /// `K⁻¹ = L⁻ᵀ L⁻¹`, `y − ŷ = (K⁻¹_ff)⁻¹ α_f` (Rasmussen & Williams 2006, section 5.4.2;
    /// Sundararajan & Keerthi 2001).
    pub(super) fn held_out_errors(&self, fold: &[usize]) -> Vec<f64> {
        let n = self.alpha.len();
        let mut block = Lower::zeros(fold.len());
        let column = |i: usize| (i, self.inverse_factor.column(i));
        for (q, &b) in fold.iter().enumerate() {
            for (p, &a) in fold.iter().enumerate().skip(q) {
                let ((i, l_i), (j, l_j)) = (column(a), column(b));
                // Columns of a lower triangle overlap only below the later diagonal.
                let from = i.max(j);
                let product = vectorised!(dot(&l_i[from - i..n - i], &l_j[from - j..n - j]));
                block.column_mut(q)[p - q] = product - self.mean_correction(i, j);
            }
        }
        let mut memory = FactorBuffers::new(fold.len());
        let mut errors: Vec<f64> = fold.iter().map(|&i| self.alpha[i]).collect();
        if block.factor(&mut memory) {
            block.solve(&mut errors, &mut memory);
        } else {
            // Without the fold the others do not determine the mean function.
            errors.fill(f64::NAN);
        }
        errors
    }

    /// What the unknown mean function takes from the inverse of the Gram matrix of an exact process
    /// at rows i and j.
    pub(super) fn mean_correction(&self, i: usize, j: usize) -> f64 {
        let Some(added) = &self.added else { return 0.0 };
        let n = self.alpha.len();
        let image = |row: &[f64], i: usize| dot(&row[i..n], self.inverse_factor.column(i));
        added
            .rows
            .chunks_exact(n + added.basis.len())
            .map(|row| image(row, i) * image(row, j))
            .sum()
    }
}
