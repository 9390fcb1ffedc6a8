//! Predictions of samples that are held out. Hyper-parameters and inducing points stay, the
//! samples' part of S leaves.

use super::SparseLikelihood;
use crate::learn::gp::covariance::TrainingPoints;
use crate::learn::gp::linear::{FactorBuffers, Lower};
use crate::learn::gp::{Approximation, Gp, GpConfig};
use crate::math::optimise::Objective;

impl<'a> SparseLikelihood<'a> {
    /// The likelihood behind output `output` of a fitted process, at its hyper-parameters.
    pub(crate) fn of(gp: &Gp, output: usize, points: &'a TrainingPoints, y: &'a [f64]) -> Self {
        let GpConfig { approximation, mean, .. } = gp.config;
        let inducing = &gp.posteriors[output].inducing;
        let mut likelihood =
            SparseLikelihood::new(approximation, mean, gp.covariance.clone(), points, y, inducing);
        likelihood.value(&gp.theta[output]);
        likelihood
    }

    /// Prediction errors (standardised) of the rows numbered `fold` when they are held out; not a
    /// number where the others leave the mean function undetermined.
    pub(crate) fn held_out_errors(&self, fold: &[usize]) -> Vec<f64> {
        let (n, width) = (self.points.n, self.width());
        // S is small; taking samples out of it is quicker than building it anew.
        let mut precision: Lower = self.precision.clone();
        let mut weights = vec![0.0; width];
        // S w is Φ Λ⁻¹ y.
        for j in 0..width {
            let column = self.precision.column(j);
            weights[j] += column[0] * self.weights[j];
            for (i, value) in column.iter().enumerate().skip(1) {
                weights[j + i] += value * self.weights[j];
                weights[j] += value * self.weights[j + i];
            }
        }
        for &row in fold {
            let features: Vec<f64> = (0..width).map(|j| self.features[j * n + row]).collect();
            for j in 0..width {
                let share = features[j] / self.diagonal[row];
                // A downdate: the sample leaves Φ Λ⁻¹ y and S.
                weights[j] -= share * self.y[row];
                let column = precision.column_mut(j);
                column
                    .iter_mut()
                    .zip(&features[j..])
                    .for_each(|(value, feature)| *value -= share * feature);
            }
        }
        let mut memory = FactorBuffers::new(width);
        if !precision.factor(&mut memory) {
            return vec![f64::NAN; fold.len()];
        }
        precision.solve(&mut weights, &mut memory);
        let predicted =
            |row: usize| (0..width).map(|j| weights[j] * self.features[j * n + row]).sum::<f64>();
        fold.iter().map(|&row| self.y[row] - predicted(row)).collect()
    }

    /// Error and variance of every sample when it is held out, standardised: the residual over `1 −
    /// h_i`, and what is not known of the function there and noise. `h_i = φ_iᵀ S⁻¹ φ_i / Λ_i` is
    /// the weight of the sample in its own prediction.
    pub(crate) fn leave_one_out_errors(&self) -> Vec<(f64, f64)> {
        let n = self.points.n;
        let mut halves = self.weighted.clone();
        self.precision_factor.solve_half_rows(&mut halves);
        let mut explained = vec![0.0; n];
        for column in halves.chunks_exact(n) {
            explained
                .iter_mut()
                .zip(column)
                .for_each(|(explained, half)| *explained += half * half);
        }
        let bound = self.approximation == Approximation::Sgpr;
        let error_and_variance = |i: usize| {
            // Sherman–Morrison for one sample that leaves the regression.
            let variance = self.diagonal[i] / (1.0 - explained[i]);
            // The diagonal of FITC holds what inducing points do not tell; that of SGPR does not.
            (
                self.alpha[i] * variance,
                variance + if bound { self.missing[i].max(0.0) } else { 0.0 },
            )
        };
        (0..n).map(error_and_variance).collect()
    }
}
