//! What a fitted sparse process predicts with.

use super::SparseLikelihood;
use crate::learn::gp::covariance::{Covariance, TrainingPoints};
use crate::learn::gp::posterior::{AddedTerm, FittedPrior, Posterior};
use crate::learn::gp::{GpConfig, sparse};
use crate::math::optimise::Objective;

impl Posterior {
    /// Conditions a sparse process on the points, with the inducing points that the
    /// hyper-parameters choose; `None` when the covariance matrices are not positive definite.
    pub(crate) fn sparse(
        config: &GpConfig,
        covariance: &Covariance,
        points: &TrainingPoints,
        y: &[f64],
        theta: &[f64],
    ) -> Option<Posterior> {
        // Chosen anew, so that a stored process needs to keep none.
        let inducing =
            sparse::greedy_conditional_variance(covariance, theta, points, config.inducing_points);
        let mut likelihood = SparseLikelihood::new(
            config.approximation,
            config.mean,
            covariance.clone(),
            points,
            y,
            &inducing,
        );
        let value = likelihood.value(theta);
        value.is_finite().then(|| likelihood.posterior(theta, inducing, value))
    }
}

impl SparseLikelihood<'_> {
    fn posterior(&self, theta: &[f64], inducing: Vec<usize>, value: f64) -> Posterior {
        let (m, width) = (self.inducing.n, self.width());
        let mut alpha = self.weights[..m].to_vec();
        // Weights of the features V become weights of the covariances: V = L⁻¹ k.
        self.inducing_factor.solve_transposed_half(&mut alpha);
        let inverse = self.precision_factor.inverse_factor();
        let mut rows = vec![0.0; width * width];
        for j in 0..width {
            inverse
                .column(j)
                .iter()
                .enumerate()
                .for_each(|(i, value)| rows[(j + i) * width + j] = *value);
        }
        Posterior {
            prior: FittedPrior::new(&self.covariance, theta, &self.inducing),
            inputs: self.points.inputs,
            alpha,
            inverse_factor: self.inducing_factor.inverse_factor(),
            log_marginal_likelihood: -value,
            added: Some(AddedTerm {
                basis: self.basis.clone(),
                weights: self.weights[m..].to_vec(),
                rows,
            }),
            inducing,
        }
    }
}
