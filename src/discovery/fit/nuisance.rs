//! Nuisance parameters: parameters that a laboratory would recalibrate, each with its calibration
//! uncertainty, and errors shared with a baseline. They are free within their priors in every
//! candidate and enter linearly.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::ar1_noise::Ar1Noise;
use crate::discovery::recording::samples::Samples;

/// Tip change per unit of a nuisance parameter, three values a sample, and the prior standard
/// deviation of its amount.
pub(crate) type NuisanceColumn = (Vec<f64>, f64);

/// Nuisance parameters with a Gaussian prior; tip change: `offset + columns · amounts`.
#[derive(Clone, Debug)]
pub(crate) struct Nuisances {
    /// Tip change at the linearisation point beyond the linear part, three values a sample, metres.
    offset: DVector<f64>,
    /// Three rows a sample, one column a parameter.
    pub(crate) columns: DMatrix<f64>,
    /// Prior mean of the amounts.
    pub(crate) mean: DVector<f64>,
    /// Prior precision of the amounts.
    pub(crate) precision: DMatrix<f64>,
    /// Log-determinant of the precision.
    log_determinant: f64,
}

/// Fit of a residual by nuisance parameters and noise.
#[derive(Clone, Debug)]
pub(crate) struct NuisanceFit {
    /// Most likely noise.
    pub(crate) noise: Ar1Noise,
    /// Most likely amounts.
    pub(crate) amounts: DVector<f64>,
    /// Remaining residual, three values a sample, metres.
    pub(crate) residual_m: Vec<f64>,
    /// Minus twice the log-likelihood with nuisance parameters integrated out.
    pub(crate) deviance: f64,
}

/// Most likely amounts with their posterior.
struct Amounts {
    values: DVector<f64>,
    /// Log-determinant of the posterior precision.
    log_determinant: f64,
    /// Effective number of parameters.
    freedom: f64,
}

/// Alternating rounds of noise and nuisance estimation (docs/method/search.md, "Noise").
const ROUNDS: usize = 5;

impl Nuisances {
    /// Independent parameters with a standard deviation each.
    pub(crate) fn independent(rows: usize, columns: &[NuisanceColumn]) -> Nuisances {
        let precision = DMatrix::from_diagonal(&DVector::from_iterator(
            columns.len(),
            columns.iter().map(|(_, deviation)| deviation.powi(-2)),
        ));
        let matrix = DMatrix::from_fn(rows, columns.len(), |row, k| columns[k].0[row]);
        Nuisances::new(matrix, DVector::zeros(columns.len()), precision)
    }

    pub(crate) fn new(
        columns: DMatrix<f64>,
        mean: DVector<f64>,
        precision: DMatrix<f64>,
    ) -> Nuisances {
        let log_determinant = log_determinant(&precision);
        Nuisances {
            offset: DVector::zeros(columns.nrows()),
            columns,
            mean,
            precision,
            log_determinant,
        }
    }

    /// The same with another prior.
    pub(crate) fn with_prior(self, mean: DVector<f64>, precision: DMatrix<f64>) -> Nuisances {
        let log_determinant = log_determinant(&precision);
        Nuisances { mean, precision, log_determinant, ..self }
    }

    /// The same with another offset.
    pub(crate) fn with_offset(self, offset: DVector<f64>) -> Nuisances {
        Nuisances { offset, ..self }
    }

    /// The same restricted to these rows (three a sample).
    pub(crate) fn in_rows(&self, rows: &[usize]) -> Nuisances {
        Nuisances {
            offset: self.offset.select_rows(rows),
            columns: self.columns.select_rows(rows),
            ..self.clone()
        }
    }

    /// Fits `residual` by nuisance parameters and noise. `freedom`: degrees of freedom used by
    /// other parameters.
    pub(crate) fn explain(&self, samples: &Samples, residual: &[f64], freedom: f64) -> NuisanceFit {
        let residual: Vec<f64> = residual
            .iter()
            .zip(self.offset.iter())
            .map(|(residual, offset)| residual - offset)
            .collect();
        let residual = residual.as_slice();
        // Noise and amounts depend on each other: estimate them in turn.
        let mut noise = Ar1Noise::estimate(samples, residual, freedom);
        let mut posterior = self.amounts(samples, residual, &noise);
        for _ in 0..ROUNDS {
            let remaining_m = self.subtract(residual, &posterior.values);
            // A nuisance parameter uses up a degree of freedom only as far as data, not prior, fix
            // it.
            noise = Ar1Noise::estimate(samples, &remaining_m, freedom + posterior.freedom);
            posterior = self.amounts(samples, residual, &noise);
        }
        let Amounts { values: amounts, log_determinant, .. } = posterior;
        let residual_m = self.subtract(residual, &amounts);
        // Minus twice the log-likelihood with the amounts integrated out (Laplace's method, exact
        // for linear columns). The deviation from the prior counts like further residuals.
        let off = &amounts - &self.mean;
        let squares: f64 = noise.whiten(samples, &residual_m).iter().map(|w| w * w).sum();
        let deviance = noise.log_determinant(samples)
            + squares
            + off.dot(&(&self.precision * &off))
            + log_determinant
            - self.log_determinant;
        NuisanceFit { noise, amounts, residual_m, deviance }
    }

    /// What the prior mean of the parameters leaves of a `residual`, three values a sample, metres.
    pub(crate) fn residual_by_prior(&self, residual: &[f64]) -> Vec<f64> {
        let remaining_m = self.subtract(residual, &self.mean);
        remaining_m
            .iter()
            .zip(self.offset.iter())
            .map(|(remaining, offset)| remaining - offset)
            .collect()
    }

    /// The largest distance of independent `amounts` from their prior mean, in standard deviations.
    pub(crate) fn deviations(&self, amounts: &DVector<f64>) -> f64 {
        let off = amounts - &self.mean;
        off.iter()
            .zip(self.precision.diagonal().iter())
            .map(|(off, precision)| off.abs() * precision.sqrt())
            .fold(0.0, f64::max)
    }

    /// Own columns followed by `others`.
    pub(crate) fn with(&self, others: &DMatrix<f64>) -> DMatrix<f64> {
        let count = self.columns.ncols();
        let mut all = self.columns.clone().resize_horizontally(count + others.ncols(), 0.0);
        all.columns_mut(count, others.ncols()).copy_from(others);
        all
    }

    /// Information matrix of own parameters and those after them (see [`Nuisances::with`]) from
    /// `white` columns and the prior.
    pub(crate) fn information(&self, white: &DMatrix<f64>) -> DMatrix<f64> {
        let mut information = white.tr_mul(white);
        let count = self.columns.ncols();
        let mut block = information.view_mut((0, 0), (count, count));
        block += &self.precision;
        information
    }

    /// Most likely amounts; the prior mean where nothing determines them.
    fn amounts(&self, samples: &Samples, residual: &[f64], noise: &Ar1Noise) -> Amounts {
        let prior = || Amounts { values: self.mean.clone(), log_determinant: 0.0, freedom: 0.0 };
        if self.mean.is_empty() {
            return prior();
        }
        let white = noise.whitened(samples, &self.columns);
        let target = DVector::from_vec(noise.whiten(samples, residual));
        let information = white.tr_mul(&white);
        let posterior = &information + &self.precision;
        // Normal equations of ridge regression towards the prior mean.
        let right = white.tr_mul(&target) + &self.precision * &self.mean;
        let Some(factor) = Cholesky::new(posterior) else { return prior() };
        // Effective number of parameters: the trace of the hat matrix.
        let freedom = factor.solve(&information).trace();
        let log_determinant = 2.0 * factor.l().diagonal().iter().map(|d| d.ln()).sum::<f64>();
        Amounts { values: factor.solve(&right), log_determinant, freedom }
    }

    fn subtract(&self, residual: &[f64], amounts: &DVector<f64>) -> Vec<f64> {
        let added = &self.columns * amounts;
        residual.iter().zip(added.iter()).map(|(r, a)| r - a).collect()
    }
}

fn log_determinant(matrix: &DMatrix<f64>) -> f64 {
    let factor = Cholesky::new(matrix.clone());
    factor.map_or(0.0, |factor| 2.0 * factor.l().diagonal().iter().map(|d| d.ln()).sum::<f64>())
}
