//! Hyper-parameters, and rows of scaled squared distances: what the Gram matrix, its gradient and
//! the predictions of every kernel are made of.

use std::sync::Arc;

use super::composite::Composite;
use super::expression::KernelExpression;
use super::kernels::{Component, Hyperparameter, Kernel, Lengths, Stationary};
use crate::base::Rows;
use crate::learn::simd::fold;
use crate::learn::{LearnError, Standardiser};
use crate::math::vectorised;

/// The covariance function of one output.
#[derive(Clone)]
pub(super) enum Covariance {
    /// One stationary kernel on all inputs: the paper's case, and quicker.
    Stationary(&'static dyn Kernel, HyperparameterLayout),
    /// Any other expression.
    Composite(Arc<Composite>),
}

impl Covariance {
    /// The covariance of `expression` on samples of `inputs` inputs.
    pub(super) fn new(
        expression: &KernelExpression,
        inputs: usize,
    ) -> Result<Covariance, LearnError> {
        Ok(match expression.stationary() {
            Some(kernel) => {
                Covariance::Stationary(kernel, HyperparameterLayout::of(kernel, inputs))
            }
            None => Covariance::Composite(Arc::new(Composite::new(expression, inputs)?)),
        })
    }

    /// Number of hyper-parameters; the noise variance is the last.
    pub(super) fn len(&self) -> usize {
        match self {
            Covariance::Stationary(_, layout) => layout.len(),
            Covariance::Composite(composite) => composite.len() + 1,
        }
    }

    pub(super) fn noise_variance(&self, theta: &[f64]) -> f64 {
        theta[self.len() - 1].exp()
    }

    /// Names and ranges of the hyper-parameters; the noise is at least the square of `noise_floor`.
    pub(super) fn hyperparameters(&self, noise_floor: f64) -> Vec<Hyperparameter> {
        let mut all = match self {
            Covariance::Stationary(kernel, layout) => {
                let of_kernel = Stationary(*kernel).hyperparameters(layout.inputs);
                std::iter::once(Hyperparameter::signal_variance("signal variance".to_owned()))
                    .chain(of_kernel)
                    .collect()
            }
            Covariance::Composite(composite) => composite.hyperparameters(),
        };
        all.push(Hyperparameter::noise_variance(noise_floor));
        all
    }
}

/// Hyper-parameters of one output, in standardised units, as logarithms in one list:
/// `ln σ_s², ln l (one or one per input), ln shape…, ln σ_n²`.
#[derive(Clone, Copy)]
pub(super) struct HyperparameterLayout {
    pub(super) inputs: usize,
    pub(super) lengths: usize,
    pub(super) shapes: usize,
}

impl HyperparameterLayout {
    pub(super) fn of(kernel: &dyn Kernel, inputs: usize) -> Self {
        let lengths = match kernel.lengths() {
            Lengths::PerInput => inputs,
            Lengths::Shared => 1,
        };
        HyperparameterLayout { inputs, lengths, shapes: kernel.shapes().len() }
    }

    pub(super) fn len(&self) -> usize {
        2 + self.lengths + self.shapes
    }

    pub(super) fn signal_variance(&self, theta: &[f64]) -> f64 {
        theta[0].exp()
    }

    pub(super) fn noise_variance(&self, theta: &[f64]) -> f64 {
        theta[self.len() - 1].exp()
    }

    /// Length-scale of each input.
    pub(super) fn length_scales(&self, theta: &[f64]) -> Vec<f64> {
        (0..self.inputs).map(|d| theta[1 + d.min(self.lengths - 1)].exp()).collect()
    }

    pub(super) fn shape(&self, theta: &[f64]) -> Vec<f64> {
        theta[1 + self.lengths..1 + self.lengths + self.shapes].iter().map(|t| t.exp()).collect()
    }
}

/// Points with each input in a run of its own, so that one instruction serves several points.
#[derive(Clone, Debug)]
pub(crate) struct TrainingPoints {
    pub(super) n: usize,
    pub(super) inputs: usize,
    values: Vec<f64>,
}

impl TrainingPoints {
    /// The rows in standardised units.
    pub(super) fn standardised(rows: &Rows, standardiser: &Standardiser) -> Self {
        let mut values = Vec::with_capacity(rows.len() * rows.width());
        for d in 0..rows.width() {
            values.extend(rows.iter().map(|row| standardiser.apply(d, row[d])));
        }
        TrainingPoints { n: rows.len(), inputs: rows.width(), values }
    }

    /// The rows as they are.
    pub(super) fn of(rows: &Rows) -> Self {
        let values = (0..rows.width()).flat_map(|d| rows.iter().map(move |row| row[d])).collect();
        TrainingPoints { n: rows.len(), inputs: rows.width(), values }
    }

    /// The points numbered `which`.
    pub(super) fn select(&self, which: &[usize]) -> Self {
        let values =
            (0..self.inputs).flat_map(|d| which.iter().map(move |&i| self.input(d)[i])).collect();
        TrainingPoints { n: which.len(), inputs: self.inputs, values }
    }

    /// Each input divided by its length-scale.
    pub(super) fn scaled(&self, length_scales: &[f64]) -> Self {
        let values = (0..self.inputs)
            .flat_map(|d| self.input(d).iter().map(move |x| x / length_scales[d]))
            .collect();
        TrainingPoints { n: self.n, inputs: self.inputs, values }
    }

    /// All inputs of point `i`.
    pub(super) fn point(&self, i: usize) -> Vec<f64> {
        (0..self.inputs).map(|d| self.input(d)[i]).collect()
    }

    /// Input `d` of every point.
    #[inline]
    pub(super) fn input(&self, d: usize) -> &[f64] {
        &self.values[d * self.n..(d + 1) * self.n]
    }

    /// Squared distances of the points from number `from` on to the point `at`.
    pub(super) fn squared_distances(&self, from: usize, at: impl Fn(usize) -> f64, s: &mut [f64]) {
        vectorised!({
            s.fill(0.0);
            for d in 0..self.inputs {
                let centre = at(d);
                for (s, x) in s.iter_mut().zip(&self.input(d)[from..]) {
                    let difference = x - centre;
                    // Differences, not |x|² + |y|² − 2 x·y, which loses all digits of near points.
                    *s = difference.mul_add(difference, *s);
                }
            }
        });
    }

    /// `Σ_i weight_i (x_i − centre)²` over input `d` of the points from number `from` on.
    #[inline(always)]
    pub(super) fn weighted_squares(
        &self,
        d: usize,
        from: usize,
        weights: &[f64],
        centre: f64,
    ) -> f64 {
        let (weights, weights_rest) = weights.as_chunks::<16>();
        let (x, x_rest) = self.input(d)[from..].as_chunks::<16>();
        // A fixed number of partial sums: the result does not depend on the vector width.
        let mut lanes = [0.0; 16];
        for (w, x) in weights.iter().zip(x) {
            for lane in 0..16 {
                let difference = x[lane] - centre;
                lanes[lane] = (w[lane] * difference).mul_add(difference, lanes[lane]);
            }
        }
        for (lane, (w, x)) in weights_rest.iter().zip(x_rest).enumerate() {
            let difference = x - centre;
            lanes[lane] = (w * difference).mul_add(difference, lanes[lane]);
        }
        fold(lanes)
    }
}
