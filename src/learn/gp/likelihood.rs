//! The log marginal likelihood and its gradient: Rasmussen & Williams 2006, eqs 5.8 and 5.9.
//!
//! With `K = σ_s² C + σ_n² I`, `α = K⁻¹ y` and `W = α αᵀ − K⁻¹`, `∂ ln p / ∂θ = ½ Σ_ij W_ij
//! ∂K_ij/∂θ`. One value costs N³/3 multiplications and additions (Cholesky), its gradient 2N³/3
//! more (the inverse) and nothing else of that order: distances, correlations and their slopes are
//! made again row by row, which is quicker than reading them back.

use super::covariance::{Covariance, HyperparameterLayout, TrainingPoints};
use super::kernels::Kernel;
use super::linear::{FactorBuffers, Lower};
use super::mean::MeanFunction;
use super::mean_regression::MeanRegression;
use super::posterior::AddedTerm;
use crate::learn::simd::dot;
use crate::math::optimise::Objective;
use crate::math::vectorised;

/// Minus the log marginal likelihood of one standardised output as a function of the logarithmic
/// hyper-parameters.
pub(super) struct Likelihood<'a> {
    pub(super) covariance: Covariance,
    pub(super) points: &'a TrainingPoints,
    y: &'a [f64],
    pub(super) theta: Vec<f64>,
    /// Inputs over length-scales at the latest value, for one stationary kernel.
    pub(super) scaled: TrainingPoints,
    /// Weight of each point, `α = K⁻¹ y`, at the latest value.
    pub(super) alpha: Vec<f64>,
    /// Cholesky factor of K at the latest value.
    pub(super) factor: Lower,
    pub(super) inverse: Lower,
    memory: FactorBuffers,
    mean: MeanRegression,
}

impl<'a> Likelihood<'a> {
    pub(super) fn new(
        covariance: Covariance,
        mean: MeanFunction,
        points: &'a TrainingPoints,
        y: &'a [f64],
    ) -> Self {
        let n = points.n;
        Likelihood {
            covariance,
            points,
            y,
            theta: Vec::new(),
            scaled: points.clone(),
            alpha: y.to_vec(),
            factor: Lower::zeros(n),
            inverse: Lower::zeros(n),
            memory: FactorBuffers::new(n),
            mean: MeanRegression::new(mean, points),
        }
    }

    /// What the mean function adds to predictions at the latest value.
    pub(super) fn added(&self) -> Option<AddedTerm> {
        self.mean.added(&self.factor)
    }

    fn fill_gram(&mut self) {
        match self.covariance.clone() {
            Covariance::Stationary(kernel, layout) => {
                self.scaled = self.points.scaled(&layout.length_scales(&self.theta));
                self.fill_stationary(kernel, layout);
            }
            Covariance::Composite(composite) => self.fill_composite(&composite),
        }
    }

    fn fill_stationary(&mut self, kernel: &dyn Kernel, layout: HyperparameterLayout) {
        let shape = layout.shape(&self.theta);
        let signal = layout.signal_variance(&self.theta);
        let diagonal = signal + layout.noise_variance(&self.theta);
        for j in 0..self.points.n {
            let column = self.factor.column_mut(j);
            self.scaled.squared_distances(j, |d| self.scaled.input(d)[j], column);
            kernel.correlations(&shape, column);
            vectorised!(column.iter_mut().for_each(|c| *c *= signal));
            // The correlation of a point with itself is 1 exactly, so no rounding enters the
            // diagonal.
            column[0] = diagonal;
        }
    }
}

impl Objective for Likelihood<'_> {
    fn value(&mut self, theta: &[f64]) -> f64 {
        if theta.iter().any(|t| !t.is_finite()) {
            return f64::INFINITY;
        }
        self.theta = theta.to_vec();
        self.fill_gram();
        if !self.factor.factor(&mut self.memory) {
            return f64::INFINITY;
        }
        // α = K⁻¹ y by two triangular solves (Rasmussen & Williams 2006, algorithm 2.1).
        self.alpha.copy_from_slice(self.y);
        self.factor.solve(&mut self.alpha, &mut self.memory);
        let data_fit = 0.5 * dot(self.y, &self.alpha);
        let normalisation = 0.5 * self.points.n as f64 * (2.0 * std::f64::consts::PI).ln();
        if self.mean.is_zero() {
            return data_fit + self.factor.half_log_determinant() + normalisation;
        }
        let Some(mean_term) = self.mean.regress(&self.factor, self.y, &mut self.alpha) else {
            return f64::INFINITY;
        };
        0.5 * dot(self.y, &self.alpha)
            + self.factor.half_log_determinant()
            + normalisation
            + mean_term
    }

    fn gradient(&mut self, out: &mut [f64]) {
        self.factor.inverse(&mut self.inverse, &mut self.memory);
        // With the weights of the mean integrated out, the projected inverse takes the place of
        // K⁻¹.
        self.mean.project(&mut self.inverse);
        match self.covariance.clone() {
            Covariance::Stationary(kernel, layout) => self.stationary_gradient(kernel, layout, out),
            Covariance::Composite(composite) => self.composite_gradient(&composite, out),
        }
    }
}

impl Likelihood<'_> {
    /// The gradient for one stationary kernel, from the inverse of the Gram matrix.
    fn stationary_gradient(
        &self,
        kernel: &dyn Kernel,
        layout: HyperparameterLayout,
        out: &mut [f64],
    ) {
        let n = self.points.n;
        let HyperparameterLayout { inputs, lengths, shapes } = layout;
        let shape = layout.shape(&self.theta);
        let signal = layout.signal_variance(&self.theta);
        out.fill(0.0);
        // A pair below the diagonal stands for both sides: no factor ½ but on the diagonal.
        let mut trace = 0.0;
        let mut rows = [(); 3].map(|()| vec![0.0; n]);
        for j in 0..n {
            let column = self.inverse.column(j);
            trace += self.alpha[j] * self.alpha[j] - column[0];
            let count = n - j - 1;
            let [s, slope, w] = rows.each_mut().map(|row| &mut row[..count]);
            let (alpha, centre) = (&self.alpha[j + 1..], self.alpha[j]);
            self.scaled.squared_distances(j + 1, |d| self.scaled.input(d)[j], s);
            vectorised!({
                for ((w, a), k) in w.iter_mut().zip(alpha).zip(&column[1..]) {
                    *w = a.mul_add(centre, -k);
                }
            });
            for k in 0..shapes {
                slope.copy_from_slice(s);
                kernel.shape_slopes(&shape, k, slope);
                out[1 + lengths + k] -= vectorised!(signal * dot(w, slope));
            }
            kernel.slopes(&shape, s, slope);
            vectorised!({
                out[0] -= signal * dot(w, s);
                // From here on w holds W ∂c/∂s: all length-scales share it.
                w.iter_mut().zip(slope.iter()).for_each(|(w, slope)| *w *= slope);
                for d in 0..inputs {
                    let centre = self.scaled.input(d)[j];
                    let sum = self.scaled.weighted_squares(d, j + 1, w, centre);
                    out[1 + d.min(lengths - 1)] += 2.0 * signal * sum;
                }
            });
        }
        // On the diagonal c = 1: only signal and noise variance change it.
        out[0] -= 0.5 * signal * trace;
        out[layout.len() - 1] = -0.5 * layout.noise_variance(&self.theta) * trace;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Rows;
    use crate::learn::Standardiser;
    use crate::learn::gp::composite::Composite;
    use crate::learn::gp::coordinates::{SearchObjective, to_search_coordinates};
    use crate::learn::gp::expression::KernelExpression;
    use crate::learn::gp::kernels::{FACTORS, KERNELS};
    use crate::math::optimise::both_gradients;
    use std::sync::Arc;

    fn samples(n: usize) -> (TrainingPoints, Vec<f64>) {
        let mut rows = Rows::new(3);
        (0..n)
            .map(|i| i as f64)
            .for_each(|i| rows.push(&[(1.7 * i).sin(), (0.9 * i).cos(), (0.31 * i * i).sin()]));
        let all: Vec<usize> = (0..n).collect();
        let y = rows
            .iter()
            .enumerate()
            .map(|(i, x)| x[0] + (2.0 * x[1]).sin() + 0.2 * (77.0 * i as f64).sin());
        let y = y.collect();
        (TrainingPoints::standardised(&rows, &Standardiser::fit(&rows, &all)), y)
    }

    /// Every stationary kernel, every other one beside one, and nested expressions.
    fn expressions() -> Vec<KernelExpression> {
        let alone = KERNELS.iter().map(|kernel| kernel.name().to_owned());
        let beside = FACTORS.iter().map(|factor| format!("se_ard + {}[1, 3]", factor.name()));
        let nested = [
            "(matern52 + linear) * (periodic[2] + constant)",
            "se[1-2] * rational_quadratic[3] + white",
        ];
        let texts = alone.chain(beside).chain(nested.map(str::to_owned));
        texts.map(|text| KernelExpression::parse(&text).unwrap()).collect()
    }

    fn somewhere(covariance: &Covariance) -> Vec<f64> {
        let mut theta: Vec<f64> =
            (0..covariance.len()).map(|k| 0.4 + 0.3 * (k as f64).sin()).collect();
        theta[covariance.len() - 1] = -2.0;
        theta
    }

    fn check_gradient(objective: &mut dyn Objective, at: &[f64], name: &str) {
        for (k, [found, expected]) in both_gradients(objective, at).into_iter().enumerate() {
            assert!((found - expected).abs() < 1e-5, "{name}, parameter {k}: {found} {expected}");
        }
    }

    #[test]
    fn gradients_are_finite_differences_for_every_kernel() {
        let (points, y) = samples(45);
        for expression in expressions() {
            let covariance = Covariance::new(&expression, 3).unwrap();
            let theta = somewhere(&covariance);
            check_gradient(
                &mut Likelihood::new(covariance.clone(), MeanFunction::Zero, &points, &y),
                &theta,
                expression.name(),
            );
            let lengths: Vec<bool> =
                covariance.hyperparameters(1.0).iter().map(|one| one.is_length).collect();
            let mut far = theta.clone();
            if let Some(length) = lengths.iter().position(|is_length| *is_length) {
                far[length] = 3.5;
            }
            let mut bent =
                SearchObjective::new(Likelihood::new(covariance, MeanFunction::Zero, &points, &y));
            check_gradient(&mut bent, &to_search_coordinates(&lengths, &far), expression.name());
        }
    }

    /// The paths for one stationary kernel and for an expression compute the same likelihood.
    #[test]
    fn both_paths_agree() {
        let (points, y) = samples(45);
        for kernel in KERNELS {
            let quick = Covariance::new(&KernelExpression::of(*kernel), 3).unwrap();
            let slow = Covariance::Composite(Arc::new(
                Composite::new(&KernelExpression::of(*kernel), 3).unwrap(),
            ));
            let theta = somewhere(&quick);
            let [(a, of_a), (b, of_b)] = [quick, slow].map(|covariance| {
                let mut likelihood = Likelihood::new(covariance, MeanFunction::Zero, &points, &y);
                let value = likelihood.value(&theta);
                let mut gradient = vec![0.0; theta.len()];
                likelihood.gradient(&mut gradient);
                (value, [gradient, likelihood.information()].concat())
            });
            assert!((a - b).abs() < 1e-9 * a.abs(), "{}: {a} {b}", kernel.name());
            let apart = of_a
                .iter()
                .zip(&of_b)
                .map(|(a, b)| (a - b).abs() / (1.0 + a.abs()))
                .fold(0.0, f64::max);
            assert!(apart < 1e-8, "{}: {apart}", kernel.name());
        }
    }

    #[test]
    fn the_estimated_information_is_near_the_exact_one() {
        let (points, y) = samples(60);
        for expression in expressions() {
            let covariance = Covariance::new(&expression, 3).unwrap();
            let (theta, count) = (somewhere(&covariance), covariance.len());
            let mut likelihood =
                Likelihood::new(covariance.clone(), MeanFunction::Zero, &points, &y);
            likelihood.value(&theta);
            let estimated = likelihood.information();
            // The noise entry is ½ σ_n⁴ tr(K⁻²), which the inverse gives exactly.
            let mut inverse = Lower::zeros(60);
            likelihood.factor.inverse(&mut inverse, &mut FactorBuffers::new(60));
            let squares = (0..60).map(|j| {
                let column = inverse.column(j);
                column[0] * column[0] + 2.0 * column[1..].iter().map(|v| v * v).sum::<f64>()
            });
            let exact = 0.5 * covariance.noise_variance(&theta).powi(2) * squares.sum::<f64>();
            let found = estimated[count * count - 1];
            assert!((found / exact - 1.0).abs() < 0.4, "{}: {found} {exact}", expression.name());
            for i in 0..count {
                for j in 0..count {
                    let (ij, ji) = (estimated[i * count + j], estimated[j * count + i]);
                    let bound = estimated[i * count + i] * estimated[j * count + j];
                    assert!(ij == ji && ij * ij <= bound * (1.0 + 1e-12));
                }
            }
        }
    }
}
