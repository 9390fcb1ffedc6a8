//! Covariances between two sets of points, and weighted sums of their derivatives.

use crate::learn::gp::composite::{Composite, PointRun};
use crate::learn::gp::composite_likelihood::natural;
use crate::learn::gp::covariance::{Covariance, HyperparameterLayout, TrainingPoints};
use crate::learn::gp::kernels::Kernel;
use crate::learn::simd::dot;
use crate::math::vectorised;

/// A covariance function under hyper-parameters. Points are given as [`CovarianceAt::prepare`]
/// returns them.
pub(crate) enum CovarianceAt<'a> {
    Stationary(StationaryAt<'a>),
    Composite { composite: &'a Composite, natural: Vec<f64> },
}

/// One stationary kernel under hyper-parameters.
pub(crate) struct StationaryAt<'a> {
    kernel: &'static dyn Kernel,
    layout: HyperparameterLayout,
    theta: &'a [f64],
}

impl<'a> CovarianceAt<'a> {
    pub(crate) fn new(covariance: &'a Covariance, theta: &'a [f64]) -> Self {
        match covariance {
            Covariance::Stationary(kernel, layout) => {
                CovarianceAt::Stationary(StationaryAt { kernel: *kernel, layout: *layout, theta })
            }
            Covariance::Composite(composite) => {
                CovarianceAt::Composite { composite, natural: natural(theta) }
            }
        }
    }

    /// Points in the units in which their distances count.
    pub(crate) fn prepare(&self, points: &TrainingPoints) -> TrainingPoints {
        match self {
            CovarianceAt::Stationary(StationaryAt { layout, theta, .. }) => {
                points.scaled(&layout.length_scales(theta))
            }
            CovarianceAt::Composite { .. } => points.clone(),
        }
    }

    /// Writes the covariances of `centre` with the points from number `from` on, without noise.
    pub(crate) fn row(
        &self,
        points: &TrainingPoints,
        from: usize,
        centre: &[f64],
        out: &mut [f64],
    ) {
        match self {
            CovarianceAt::Stationary(StationaryAt { kernel, layout, theta }) => {
                let signal = layout.signal_variance(theta);
                points.squared_distances(from, |d| centre[d], out);
                kernel.correlations(&layout.shape(theta), out);
                vectorised!(out.iter_mut().for_each(|value| *value *= signal));
            }
            CovarianceAt::Composite { composite, natural } => {
                composite.row(natural, PointRun { points, from, self_index: None }, centre, out)
            }
        }
    }

    /// Writes the variance of every point and the noise that the kernel gives it beside. Points
    /// count as they are.
    pub(crate) fn diagonal(
        &self,
        points: &TrainingPoints,
        variances: &mut [f64],
        noises: &mut [f64],
    ) {
        match self {
            CovarianceAt::Stationary(StationaryAt { layout, theta, .. }) => {
                variances.fill(layout.signal_variance(theta));
                noises.fill(0.0);
            }
            CovarianceAt::Composite { composite, natural } => {
                for i in 0..points.n {
                    let at = points.point(i);
                    let mut noisy_variance = [0.0];
                    composite.row(
                        natural,
                        PointRun { points, from: i, self_index: Some(0) },
                        &at,
                        &mut noisy_variance,
                    );
                    variances[i] = composite.variance(natural, &at);
                    // What only a training point has with itself is the kernel's own noise.
                    noises[i] = noisy_variance[0] - variances[i];
                }
            }
        }
    }

    /// Adds to `out` the derivatives of `Σ weight_i k(centre, x_i)` over the points from number
    /// `from` on with respect to the logarithm of every hyper-parameter. The weights are used as
    /// working memory.
    pub(crate) fn add_row_rates(
        &self,
        points: &TrainingPoints,
        from: usize,
        centre: &[f64],
        weights: &mut [f64],
        out: &mut [f64],
    ) {
        match self {
            CovarianceAt::Stationary(stationary) => {
                stationary.add_row_rates(points, from, centre, weights, out)
            }
            CovarianceAt::Composite { composite, natural } => {
                let row = composite.row_rates(
                    natural,
                    PointRun { points, from, self_index: None },
                    centre,
                );
                let mut rates = vec![0.0; weights.len()];
                for (k, out) in out.iter_mut().enumerate().take(composite.len()) {
                    composite.rate(natural, &row, k, &mut rates);
                    *out += dot(weights, &rates);
                }
            }
        }
    }

    /// Adds to `out` the derivatives of `Σ variance_weight_i k_ii + noise_weight_i w_i` for the
    /// variance k and the kernel's own noise w of every point. Points count as they are.
    pub(crate) fn add_diagonal_rates(
        &self,
        points: &TrainingPoints,
        variance_weights: &[f64],
        noise_weights: &[f64],
        out: &mut [f64],
    ) {
        match self {
            CovarianceAt::Stationary(StationaryAt { layout, theta, .. }) => {
                out[0] += layout.signal_variance(theta) * variance_weights.iter().sum::<f64>();
            }
            CovarianceAt::Composite { composite, natural } => {
                for i in 0..points.n {
                    let (single, at) = (points.select(&[i]), points.point(i));
                    let run = |self_index: Option<usize>| PointRun {
                        points: &single,
                        from: 0,
                        self_index,
                    };
                    let of_variance = composite.row_rates(natural, run(None), &at);
                    let with_noise = composite.row_rates(natural, run(Some(0)), &at);
                    for (k, out) in out.iter_mut().enumerate().take(composite.len()) {
                        let (mut variance, mut noisy_variance) = ([0.0], [0.0]);
                        composite.rate(natural, &of_variance, k, &mut variance);
                        composite.rate(natural, &with_noise, k, &mut noisy_variance);
                        *out += variance_weights[i] * variance[0]
                            + noise_weights[i] * (noisy_variance[0] - variance[0]);
                    }
                }
            }
        }
    }
}

impl StationaryAt<'_> {
    /// [`CovarianceAt::add_row_rates`] for one stationary kernel.
    fn add_row_rates(
        &self,
        points: &TrainingPoints,
        from: usize,
        centre: &[f64],
        weights: &mut [f64],
        out: &mut [f64],
    ) {
        let StationaryAt { kernel, layout, theta } = *self;
        let HyperparameterLayout { inputs, lengths, shapes } = layout;
        let (shape, signal) = (layout.shape(theta), layout.signal_variance(theta));
        let (mut s, mut slope) = (vec![0.0; weights.len()], vec![0.0; weights.len()]);
        points.squared_distances(from, |d| centre[d], &mut s);
        for k in 0..shapes {
            slope.copy_from_slice(&s);
            kernel.shape_slopes(&shape, k, &mut slope);
            out[1 + lengths + k] += signal * dot(weights, &slope);
        }
        kernel.slopes(&shape, &mut s, &mut slope);
        vectorised!({
            out[0] += signal * dot(weights, &s);
            weights.iter_mut().zip(&slope).for_each(|(weight, slope)| *weight *= slope);
            for d in 0..inputs {
                out[1 + d.min(lengths - 1)] -=
                    2.0 * signal * points.weighted_squares(d, from, weights, centre[d]);
            }
        });
    }
}
