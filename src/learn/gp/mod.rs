//! Gaussian-process regression (paper IV-B, eqs 18–20): several outputs, each with its own
//! hyper-parameters, which maximise the log marginal likelihood. Exact, or sparse with inducing
//! points; with zero mean or a mean function.

mod composite;
mod composite_likelihood;
mod config;
mod coordinates;
mod covariance;
mod cross_validation;
mod curvature;
mod expression;
mod leave_one_out;
mod likelihood;
mod linear;
mod mean;
mod mean_regression;
mod noise_prior;
mod online;
mod posterior;
mod range_ends;
mod search;
mod sparse;
mod stored;

pub mod kernels;

pub use config::{Approximation, FoldOrder, GpConfig, Lambda};
pub use expression::{ExpressionError, KernelExpression};
pub use leave_one_out::LeaveOneOut;
pub use mean::MeanFunction;
pub use noise_prior::NoisePrior;
pub use online::{Leaving, OnlineGp};
pub use range_ends::RangeEnd;

use serde::{Deserialize, Serialize};

use super::standardise::{check_finite, check_samples};
use super::{LearnError, Standardiser};
use crate::base::Rows;
use covariance::{Covariance, TrainingPoints};
use posterior::{BLOCK, Posterior};

/// A fitted Gaussian process. Written by serde as its data and hyper-parameters; what is read back
/// predicts the same bits.
#[derive(Clone, Serialize, Deserialize)]
#[serde(try_from = "stored::StoredGp", into = "stored::StoredGp")]
pub struct Gp {
    config: GpConfig,
    inputs: Rows,
    outputs: Rows,
    input_standardiser: Standardiser,
    output_standardiser: Standardiser,
    theta: Vec<Vec<f64>>,
    covariance: Covariance,
    posteriors: Vec<Posterior>,
    evaluations: usize,
}

impl std::fmt::Debug for Gp {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Gp")
            .field("config", &self.config)
            .field("points", &self.inputs.len())
            .finish_non_exhaustive()
    }
}

/// Mean and variance of every output at one point or, as rows, at many.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// Posterior means, in the outputs' unit: one row per query.
    pub mean: Rows,
    /// Variances of the noise-free function, in the outputs' unit squared: one row per query.
    pub variance: Rows,
}

impl Gp {
    /// Fits every column of `outputs` (N rows) to `inputs` (N rows) by maximum marginal likelihood,
    /// times the prior of the noise where there is one, on one thread.
    ///
    /// # Errors
    /// Numbers that are not finite, fewer than 2 rows, tables of different lengths, settings out of
    /// range, a kernel on inputs that are not there.
    pub fn fit(inputs: &Rows, outputs: &Rows, config: &GpConfig) -> Result<Gp, LearnError> {
        config.check()?;
        check_samples(inputs, outputs)?;
        Self::check_rows(inputs, config)?;
        let covariance = Covariance::new(&config.kernel, inputs.width())?;
        let (points, columns) = Self::prepare(inputs, outputs);
        let all: Vec<usize> = (0..outputs.len()).collect();
        let scale = Standardiser::fit(outputs, &all);
        let mut evaluations = 0;
        let mut theta = Vec::with_capacity(columns.len());
        for (output, y) in columns.iter().enumerate() {
            // Outputs differ in smoothness and noise, so each has its own hyper-parameters.
            let search =
                if config.approximation.is_exact() { search::search } else { sparse::search };
            let prior =
                config.noise_prior.and_then(|prior| prior.standardised(scale.scale(output)));
            let optimum = search(config, prior, &covariance, &points, y)
                .ok_or(LearnError::NotPositiveDefinite { output })?;
            evaluations += optimum.evaluations;
            theta.push(optimum.theta);
        }
        Self::condition(inputs, outputs, config, theta, evaluations)
    }

    /// Conditions on the samples under given hyper-parameters, without a search: `theta` holds, per
    /// output, the natural logarithms of signal variance, length-scales, shapes and noise variance
    /// in standardised units, in the order of [`Gp::theta`].
    ///
    /// # Errors
    /// As [`Gp::fit`]; [`LearnError::NotPositiveDefinite`] when the hyper-parameters leave no
    /// usable covariance.
    pub fn condition(
        inputs: &Rows,
        outputs: &Rows,
        config: &GpConfig,
        theta: Vec<Vec<f64>>,
        evaluations: usize,
    ) -> Result<Gp, LearnError> {
        check_samples(inputs, outputs)?;
        Self::check_rows(inputs, config)?;
        let covariance = Covariance::new(&config.kernel, inputs.width())?;
        let (points, columns) = Self::prepare(inputs, outputs);
        LearnError::unless_shape("outputs with hyper-parameters", theta.len(), columns.len())?;
        let mut posteriors = Vec::with_capacity(columns.len());
        for (output, (y, theta)) in columns.iter().zip(&theta).enumerate() {
            LearnError::unless_shape("hyper-parameters", theta.len(), covariance.len())?;
            let posterior = match config.approximation {
                Approximation::Exact => {
                    Posterior::exact(&covariance, config.mean, &points, y, theta)
                }
                Approximation::Sgpr | Approximation::Fitc => {
                    Posterior::sparse(config, &covariance, &points, y, theta)
                }
            };
            posteriors.push(posterior.ok_or(LearnError::NotPositiveDefinite { output })?);
        }
        let all: Vec<usize> = (0..inputs.len()).collect();
        Ok(Gp {
            config: config.clone(),
            input_standardiser: Standardiser::fit(inputs, &all),
            output_standardiser: Standardiser::fit(outputs, &all),
            inputs: inputs.clone(),
            outputs: outputs.clone(),
            theta,
            covariance,
            posteriors,
            evaluations,
        })
    }

    /// Enough rows for kernel, noise and mean function, and not more than the process can take.
    fn check_rows(inputs: &Rows, config: &GpConfig) -> Result<(), LearnError> {
        let (rows, needed) = (inputs.len(), config.mean.least_rows(inputs.width()));
        if rows < needed {
            let why = if config.mean.is_zero() {
                "a Gaussian process and its noise"
            } else {
                "a Gaussian process, its noise and the weights of its mean function"
            };
            return Err(LearnError::TooFewRows { found: rows, needed, why });
        }
        config.check_points(rows)
    }

    /// Standardised inputs and output columns.
    fn prepare(inputs: &Rows, outputs: &Rows) -> (TrainingPoints, Vec<Vec<f64>>) {
        let all: Vec<usize> = (0..inputs.len()).collect();
        let points = TrainingPoints::standardised(inputs, &Standardiser::fit(inputs, &all));
        let scale = Standardiser::fit(outputs, &all);
        let column = |c: usize| outputs.iter().map(|row| scale.apply(c, row[c])).collect();
        (points, (0..outputs.width()).map(column).collect())
    }

    /// Training points.
    pub fn points(&self) -> usize {
        self.inputs.len()
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.inputs.width()
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.outputs.width()
    }

    /// The outputs that it was fitted to: one row a point, in their unit.
    pub fn training_outputs(&self) -> &Rows {
        &self.outputs
    }

    /// The settings of the fit.
    pub fn config(&self) -> &GpConfig {
        &self.config
    }

    /// Likelihood evaluations that the search took, over all outputs and sizes.
    pub fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// Log marginal likelihood of each output (nats), of the standardised values: of `sgpr` its
    /// lower bound, of `fitc` that of the approximate process, with a mean function without its
    /// weights.
    pub fn log_marginal_likelihood(&self) -> Vec<f64> {
        self.posteriors.iter().map(|posterior| posterior.log_marginal_likelihood).collect()
    }

    /// Noise standard deviation σ_n of each output, in its unit; without that of `white` in an
    /// expression.
    pub fn noise_std(&self) -> Vec<f64> {
        let noise = |(c, theta): (usize, &Vec<f64>)| {
            self.covariance.noise_variance(theta).sqrt() * self.output_standardiser.scale(c)
        };
        self.theta.iter().enumerate().map(noise).collect()
    }

    /// `l` of each output (row) and input (column) as the configured reading of eq. 18 has it: in
    /// the inputs' units ([`Lambda::InverseSquares`]) or their inverses ([`Lambda::AsPrinted`]).
    /// `None` for an expression of several kernels.
    pub fn length_scales(&self) -> Option<Rows> {
        let Covariance::Stationary(_, layout) = self.covariance else { return None };
        let mut out = Rows::new(self.inputs.width());
        for theta in &self.theta {
            let row: Vec<f64> = layout
                .length_scales(theta)
                .iter()
                .enumerate()
                .map(|(d, l)| l * self.input_standardiser.scale(d))
                .map(|l| if self.config.lambda == Lambda::AsPrinted { 1.0 / l } else { l })
                .collect();
            out.push(&row);
        }
        Some(out)
    }

    /// Names of the hyper-parameters in the order of [`Gp::theta`].
    pub fn hyperparameter_names(&self) -> Vec<String> {
        self.covariance
            .hyperparameters(self.config.noise_floor)
            .into_iter()
            .map(|parameter| parameter.name)
            .collect()
    }

    /// Logarithms of the hyper-parameters of each output in standardised units: for one stationary
    /// kernel signal variance, length-scales, the kernel's shapes, noise variance; for an
    /// expression the signal variance of each product, those of each factor, noise variance.
    pub fn theta(&self) -> &[Vec<f64>] {
        &self.theta
    }

    /// Most points that the prediction of an output compares with.
    fn max_points(&self) -> usize {
        self.posteriors.iter().map(Posterior::points).max().unwrap_or(0)
    }

    fn standardised(&self, input: &[f64]) -> Vec<f64> {
        input.iter().enumerate().map(|(d, x)| self.input_standardiser.apply(d, *x)).collect()
    }

    fn check_width(&self, found: usize) -> Result<(), LearnError> {
        LearnError::unless_shape("columns of a query", found, self.inputs.width())
    }

    /// Posterior mean of every output at one point, in the outputs' units (paper eq. 19).
    ///
    /// # Errors
    /// [`LearnError::Shape`] for a query of another width.
    pub fn mean(&self, input: &[f64]) -> Result<Vec<f64>, LearnError> {
        self.check_width(input.len())?;
        let x = self.standardised(input);
        let mut k = vec![0.0; self.max_points()];
        let mean_of = |(c, p): (usize, &Posterior)| {
            self.output_standardiser.invert(c, p.mean(&x, &mut k[..p.points()]))
        };
        Ok(self.posteriors.iter().enumerate().map(mean_of).collect())
    }

    /// Posterior mean and variance (of the noise-free function) of every output at one point (paper
    /// eq. 19).
    ///
    /// # Errors
    /// [`LearnError::Shape`] for a query of another width.
    pub fn predict(&self, input: &[f64]) -> Result<(Vec<f64>, Vec<f64>), LearnError> {
        self.check_width(input.len())?;
        let x = self.standardised(input);
        let (mut k, mut v) = (vec![0.0; self.max_points()], vec![0.0; self.max_points()]);
        let both = self.posteriors.iter().enumerate().map(|(c, posterior)| {
            let n = posterior.points();
            let (mean, variance) = posterior.mean_variance(&x, &mut k[..n], &mut v[..n]);
            let scale = self.output_standardiser.scale(c);
            (self.output_standardiser.invert(c, mean), variance * scale * scale)
        });
        Ok(both.unzip())
    }

    /// Posterior means at many points: one row per row of `inputs`.
    ///
    /// # Errors
    /// Queries of another width or with numbers that are not finite.
    pub fn mean_rows(&self, inputs: &Rows) -> Result<Rows, LearnError> {
        self.check_width(inputs.width())?;
        check_finite("inputs", inputs)?;
        let mut out = Rows::new(self.outputs());
        for row in inputs.iter() {
            out.push(&self.mean(row)?);
        }
        Ok(out)
    }

    /// Posterior means and variances at many points: one row per row of `inputs`.
    ///
    /// # Errors
    /// Queries of another width or with numbers that are not finite.
    pub fn predict_rows(&self, inputs: &Rows) -> Result<Prediction, LearnError> {
        self.check_width(inputs.width())?;
        check_finite("inputs", inputs)?;
        let width = self.outputs();
        let (mut mean, mut variance) = (Rows::new(width), Rows::new(width));
        let (mut k, mut v) =
            (vec![0.0; self.max_points() * BLOCK], vec![0.0; self.max_points() * BLOCK]);
        for block in inputs.values().chunks(BLOCK * self.inputs()) {
            let count = block.len() / self.inputs();
            let queries: Vec<f64> =
                block.chunks_exact(self.inputs()).flat_map(|row| self.standardised(row)).collect();
            let (mut means, mut variances) = (vec![0.0; count * width], vec![0.0; count * width]);
            for (c, posterior) in self.posteriors.iter().enumerate() {
                let scale = self.output_standardiser.scale(c);
                posterior.block(&queries, &mut k, &mut v, |q, m, s| {
                    means[q * width + c] = self.output_standardiser.invert(c, m);
                    variances[q * width + c] = s * scale * scale;
                });
            }
            means.chunks_exact(width).for_each(|row| mean.push(row));
            variances.chunks_exact(width).for_each(|row| variance.push(row));
        }
        Ok(Prediction { mean, variance })
    }
}
