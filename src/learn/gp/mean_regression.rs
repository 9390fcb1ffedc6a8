//! The weights of a mean function beside the exact likelihood.

use super::covariance::TrainingPoints;
use super::linear::{FactorBuffers, Lower};
use super::mean::{MeanBasis, MeanFunction};
use super::posterior::AddedTerm;
use crate::learn::simd::dot;

/// The basis functions at the points, and what generalised least squares makes of them.
#[derive(Default)]
pub(super) struct MeanRegression {
    basis: MeanBasis,
    /// H: n rows, a column a basis function.
    columns: Vec<f64>,
    /// `K⁻¹ H`, and that times `L_A⁻ᵀ` for `A = Hᵀ K⁻¹ H = L_A L_Aᵀ`.
    solved: Vec<f64>,
    halves: Vec<f64>,
    factor: Option<Lower>,
    /// β.
    weights: Vec<f64>,
}

impl MeanRegression {
    pub(super) fn new(mean: MeanFunction, points: &TrainingPoints) -> Self {
        let basis = MeanBasis::of(mean, points);
        let columns = basis.columns(points);
        MeanRegression { basis, columns, ..MeanRegression::default() }
    }

    pub(super) fn is_zero(&self) -> bool {
        self.basis.len() == 0
    }

    /// Takes the fitted mean out of `alpha`, which is `K⁻¹ y` before; returns what integrating the
    /// weights out adds to minus the log likelihood (Rasmussen & Williams 2006, eq. 2.45), `None`
    /// when the points do not tell the weights.
    pub(super) fn regress(&mut self, gram: &Lower, y: &[f64], alpha: &mut [f64]) -> Option<f64> {
        let (n, count) = (y.len(), self.basis.len());
        self.solved = self.columns.clone();
        // 1. K⁻¹ H.
        gram.solve_half(&mut self.solved);
        gram.solve_transposed_half(&mut self.solved);
        // 2. A = Hᵀ K⁻¹ H and its Cholesky factor.
        let mut factor = Lower::zeros(count);
        for j in 0..count {
            for i in j..count {
                factor.column_mut(j)[i - j] =
                    dot(&self.columns[i * n..(i + 1) * n], &self.solved[j * n..(j + 1) * n]);
            }
        }
        let mut memory = FactorBuffers::new(count);
        // With no more points than weights nothing is left for kernel and noise.
        if n <= count || !factor.factor(&mut memory) {
            return None;
        }
        // β = A⁻¹ Hᵀ K⁻¹ y (Rasmussen & Williams 2006, eq. 2.41).
        self.weights = self.columns.chunks_exact(n).map(|column| dot(column, alpha)).collect();
        factor.solve(&mut self.weights, &mut memory);
        for (weight, solved) in self.weights.iter().zip(self.solved.chunks_exact(n)) {
            alpha.iter_mut().zip(solved).for_each(|(alpha, solved)| *alpha -= weight * solved);
        }
        // 3. ½ ln det A, and the constants that the weights take from the normalisation.
        let normalisation = 0.5 * count as f64 * (2.0 * std::f64::consts::PI).ln();
        let mean_term = factor.half_log_determinant() - normalisation;
        self.halves = self.solved.clone();
        factor.solve_half_rows(&mut self.halves);
        self.factor = Some(factor);
        Some(mean_term)
    }

    /// Takes what the weights explain out of the inverse of the Gram matrix: `K⁻¹ − K⁻¹ H A⁻¹ Hᵀ
    /// K⁻¹`.
    pub(super) fn project(&self, inverse: &mut Lower) {
        if self.is_zero() {
            return;
        }
        let n = self.columns.len() / self.basis.len();
        for half in self.halves.chunks_exact(n) {
            for j in 0..n {
                let weight = half[j];
                inverse
                    .column_mut(j)
                    .iter_mut()
                    .zip(&half[j..])
                    .for_each(|(value, half)| *value -= weight * half);
            }
        }
    }

    /// What the mean adds to predictions, given the factor of the Gram matrix: `E = L_A⁻¹ (−(L⁻¹
    /// H)ᵀ, 1)`.
    pub(super) fn added(&self, gram: &Lower) -> Option<AddedTerm> {
        let factor = self.factor.as_ref()?;
        let count = self.basis.len();
        let n = self.columns.len() / count;
        let mut halves = self.columns.clone();
        gram.solve_half(&mut halves);
        // A column a row of E before L_A⁻¹.
        let width = n + count;
        let mut rows = vec![0.0; width * count];
        for (k, (row, half)) in rows.chunks_exact_mut(width).zip(halves.chunks_exact(n)).enumerate()
        {
            row.iter_mut().zip(half).for_each(|(row, half)| *row = -half);
            row[n + k] = 1.0;
        }
        factor.solve_half_rows(&mut rows);
        Some(AddedTerm { basis: self.basis.clone(), weights: self.weights.clone(), rows })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Rows;
    use crate::learn::gp::covariance::Covariance;
    use crate::learn::gp::likelihood::Likelihood;
    use crate::learn::gp::{Gp, GpConfig, KernelExpression};
    use crate::math::optimise::both_gradients;

    const MEANS: [MeanFunction; 2] = [MeanFunction::Constant, MeanFunction::Linear];

    /// A plane with a ripple on a patch that is far from the origin.
    fn table(n: usize) -> (Rows, Rows) {
        let (mut inputs, mut outputs) = (Rows::new(2), Rows::new(1));
        for i in (0..n).map(|i| i as f64) {
            let x = [3.0 + (1.7 * i).sin(), -2.0 + 0.5 * (0.9 * i).cos()];
            inputs.push(&x);
            outputs.push(&[4.0 + 2.0 * x[0] - 3.0 * x[1]
                + 0.05 * (9.0 * x[0]).sin()
                + 0.01 * (77.0 * i).sin()]);
        }
        (inputs, outputs)
    }

    #[test]
    fn gradients_with_a_mean_are_finite_differences() {
        let (inputs, outputs) = table(40);
        let points = TrainingPoints::of(&inputs);
        let y: Vec<f64> = outputs.values().iter().map(|value| value - 10.0).collect();
        for text in ["se_ard", "matern32 + white", "se_ard[1] * periodic[2]"] {
            let covariance = Covariance::new(&KernelExpression::parse(text).unwrap(), 2).unwrap();
            let mut theta: Vec<f64> =
                (0..covariance.len()).map(|k| 0.3 * (k as f64).cos()).collect();
            theta[covariance.len() - 1] = -3.0;
            for mean in MEANS {
                let mut likelihood = Likelihood::new(covariance.clone(), mean, &points, &y);
                for (k, [found, expected]) in
                    both_gradients(&mut likelihood, &theta).into_iter().enumerate()
                {
                    let apart = (found - expected).abs() / (1.0 + expected.abs());
                    assert!(apart < 1e-5, "{text} {mean:?} {k}: {found} {expected}");
                }
            }
        }
    }

    /// A mean with unknown weights is a zero mean and a kernel of very uncertain weights (Rasmussen
    /// & Williams 2006, eq. 2.40).
    #[test]
    fn predictions_are_those_of_a_kernel_with_very_uncertain_weights() {
        let (inputs, outputs) = table(40);
        let at = [3.4, -1.9];
        let noise = 0.01_f64.ln();
        // Signal variances of both products, length-scales, and scales of the dot product.
        let wide = [
            ("se_ard + constant", MeanFunction::Constant, vec![0.5, 1e7, 0.8, 1.2]),
            (
                "se_ard + constant + linear",
                MeanFunction::Linear,
                vec![0.5, 1e7, 1e7, 0.8, 1.2, 1.0, 1.0],
            ),
        ];
        for (kernel, mean, natural) in wide {
            let of = |kernel: &str, mean: MeanFunction, theta: Vec<f64>| {
                let config = GpConfig {
                    kernel: KernelExpression::parse(kernel).unwrap(),
                    mean,
                    ..GpConfig::default()
                };
                let gp = Gp::condition(&inputs, &outputs, &config, vec![theta], 0).unwrap();
                let (value, variance) = gp.predict(&at).unwrap();
                (value[0], variance[0], gp.cross_validation_mae()[0])
            };
            let theta = natural.iter().map(|value: &f64| value.ln()).chain([noise]).collect();
            let (a, b, c) = of(kernel, MeanFunction::Zero, theta);
            let (mean_value, variance, error) = of(
                "se_ard",
                mean,
                [0.5, 0.8, 1.2].map(f64::ln).into_iter().chain([noise]).collect(),
            );
            assert!(
                (a - mean_value).abs() < 1e-5 && (b / variance - 1.0).abs() < 1e-4,
                "{kernel}: {a} {mean_value} {b} {variance}"
            );
            assert!((c - error).abs() < 1e-5, "{kernel}: {c} {error}");
        }
    }

    #[test]
    fn far_from_the_samples_a_linear_mean_goes_on_and_its_variance_grows() {
        let (inputs, outputs) = table(60);
        let fit = |mean: MeanFunction| {
            Gp::fit(&inputs, &outputs, &GpConfig { mean, starts: 2, ..GpConfig::default() })
                .unwrap()
        };
        let linear = fit(MeanFunction::Linear);
        let plane = |x: [f64; 2]| 4.0 + 2.0 * x[0] - 3.0 * x[1];
        let (far, farther) = ([23.0, 8.0], [43.0, 18.0]);
        let (value, variance) = linear.predict(&far).unwrap();
        assert!(
            (value[0] - plane(far)).abs() < 3.0 * variance[0].sqrt() + 0.5,
            "{} {}",
            value[0],
            plane(far)
        );
        assert!(linear.predict(&farther).unwrap().1[0] > 2.0 * variance[0]);
        let error = |gp: &Gp| (gp.mean(&far).unwrap()[0] - plane(far)).abs();
        assert!(error(&linear) < 0.1 * error(&fit(MeanFunction::Constant)));
    }
}
