//! Leave-one-out predictions (Rasmussen & Williams 2006, section 5.4.2): every sample as the others
//! foretell it.

use super::sparse::SparseLikelihood;
use super::{Gp, Posterior};
use crate::base::Rows;
use crate::learn::simd::dot;

/// Every sample as a process foretells it that has not seen it: hyper-parameters (and inducing
/// points) stay as they are. One row a sample, one column an output.
#[derive(Clone, Debug, PartialEq)]
pub struct LeaveOneOut {
    /// Means, in the outputs' unit.
    pub mean: Rows,
    /// Variances of the sample, noise and all, in the outputs' unit squared.
    pub variance: Rows,
    /// Logarithms of the probability density of the sample: eq. 5.10.
    pub log_probability: Rows,
}

impl Gp {
    /// Leave-one-out predictions of every sample without fitting anew: eqs 5.10 to 5.12, with the
    /// unknown weights of a mean function integrated out. Costs N² multiplications for an output.
    pub fn leave_one_out(&self) -> LeaveOneOut {
        let n = self.points();
        let (points, columns) = Self::prepare(&self.inputs, &self.outputs);
        let errors: Vec<Vec<(f64, f64)>> = (self.posteriors.iter().enumerate())
            .map(|(c, posterior)| {
                if self.config.approximation.is_exact() {
                    return posterior.leave_one_out_errors();
                }
                SparseLikelihood::of(self, c, &points, &columns[c]).leave_one_out_errors()
            })
            .collect();
        let [mut mean, mut variance, mut log_probability] =
            [(); 3].map(|()| Rows::new(self.outputs()));
        for i in 0..n {
            let predicted = |c: usize| {
                let ((error, variance), scale) = (errors[c][i], self.output_standardiser.scale(c));
                (self.outputs.row(i)[c] - error * scale, variance * scale * scale)
            };
            let (means, variances): (Vec<f64>, Vec<f64>) =
                (0..self.outputs()).map(predicted).unzip();
            let density = |c: usize| {
                let error = self.outputs.row(i)[c] - means[c];
                -0.5 * ((2.0 * std::f64::consts::PI * variances[c]).ln()
                    + error * error / variances[c])
            };
            log_probability.push(&(0..self.outputs()).map(density).collect::<Vec<f64>>());
            mean.push(&means);
            variance.push(&variances);
        }
        LeaveOneOut { mean, variance, log_probability }
    }
}

impl Posterior {
    /// Error and variance of every sample of an exact process when it is held out, standardised:
    /// `α_i / (K⁻¹)_ii` and `1 / (K⁻¹)_ii`.
    fn leave_one_out_errors(&self) -> Vec<(f64, f64)> {
        let error_and_variance = |(i, alpha): (usize, &f64)| {
            let column = self.inverse_factor.column(i);
            // (K⁻¹)_ii is the squared length of column i of L⁻¹.
            let precision = dot(column, column) - self.mean_correction(i, i);
            (alpha / precision, 1.0 / precision)
        };
        self.alpha.iter().enumerate().map(error_and_variance).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::gp::{Approximation, GpConfig, KernelExpression, MeanFunction};

    fn table(n: usize) -> (Rows, Rows) {
        let (mut inputs, mut outputs) = (Rows::new(2), Rows::new(2));
        for i in (0..n).map(|i| i as f64) {
            let x = [(1.7 * i).sin(), (0.9 * i).cos()];
            inputs.push(&x);
            outputs.push(&[
                0.01 * (x[0] + (2.0 * x[1]).sin() + 0.1 * (77.0 * i).sin()),
                x[0] * x[1] + 3.0,
            ]);
        }
        (inputs, outputs)
    }

    /// Against a process whose sample `out` is so noisy that it tells nothing: `white` on an input
    /// that only that sample has.
    #[test]
    fn every_sample_is_foretold_as_by_a_process_without_it() {
        let (inputs, outputs) = table(30);
        let kernel = KernelExpression::parse("se_ard + linear").unwrap();
        let theta: Vec<f64> = [0.8_f64, 0.4, 0.9, 1.3, 1.0, 2.0, 0.02].map(f64::ln).to_vec();
        for mean in [MeanFunction::Zero, MeanFunction::Linear] {
            for approximation in [Approximation::Exact, Approximation::Sgpr, Approximation::Fitc] {
                let config =
                    GpConfig { kernel: kernel.clone(), mean, approximation, ..GpConfig::default() };
                let gp =
                    Gp::condition(&inputs, &outputs, &config, vec![theta.clone(); 2], 0).unwrap();
                let held_out = gp.leave_one_out();
                // Folds of one row are the same predictions by another formula.
                let folds = GpConfig { folds: 30, ..config.clone() };
                let by_folds =
                    Gp::condition(&inputs, &outputs, &folds, vec![theta.clone(); 2], 0).unwrap();
                for (c, expected) in by_folds.cross_validation_mae().iter().enumerate() {
                    let errors =
                        (0..30).map(|i| (outputs.row(i)[c] - held_out.mean.row(i)[c]).abs());
                    let mae = errors.sum::<f64>() / 30.0;
                    assert!(
                        (mae / expected - 1.0).abs() < 1e-6,
                        "{mean:?} {approximation:?}: {mae} {expected}"
                    );
                }
                // The variance is that of the process at the sample without it, and noise: rank-one
                // formula on the posterior.
                for (i, row) in inputs.iter().enumerate() {
                    let (_, variance_of_fit) = gp.predict(row).unwrap();
                    for c in 0..2 {
                        let noise = gp.noise_std()[c].powi(2);
                        let without = 1.0 / (1.0 / variance_of_fit[c] - 1.0 / noise);
                        let expected = without + noise;
                        let variance = held_out.variance.row(i)[c];
                        let loose = if approximation == Approximation::Fitc { 1e-2 } else { 1e-5 };
                        assert!(
                            (variance / expected - 1.0).abs() < loose,
                            "{i} {approximation:?}: {variance} {expected}"
                        );
                        let z = (outputs.row(i)[c] - held_out.mean.row(i)[c]) / variance.sqrt();
                        let density =
                            -0.5 * z * z - (variance * 2.0 * std::f64::consts::PI).sqrt().ln();
                        assert!((density - held_out.log_probability.row(i)[c]).abs() < 1e-9);
                    }
                }
            }
        }
    }
}
