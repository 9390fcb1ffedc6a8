//! Linear screening: how much of the residual each candidate would explain if the tip responded
//! linearly.

use std::collections::BTreeSet;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::discovery::fit::ar1_noise::Ar1Noise;
use crate::discovery::fit::candidate::{CandidateEffect, SetMember};
use crate::discovery::fit::nuisance::Nuisances;
use crate::discovery::fit::sensitivities::Sensitivity;
use crate::discovery::recording::samples::{Samples, rms_m};

/// Predicted scores below this are not fitted; nor are rough fits that reduce the score by more
/// than this and the rival margin.
pub(crate) const MIN_PREDICTED_SCORE: f64 = -6.0;
/// A large-amplitude sensitivity holds for steps between these multiples of its own.
pub(crate) const VALID_STEPS: std::ops::Range<f64> = 0.3..2.0;

/// Linear prediction for a variant of a candidate.
#[derive(Clone, Debug)]
pub(crate) struct LinearPrediction {
    /// The candidate with its predicted values.
    pub(crate) member: SetMember,
    /// Index of the sensitivity used.
    pub(crate) sensitivity: usize,
    /// Predicted step over that of the sensitivity; one for small-step sensitivities.
    pub(crate) share: f64,
    /// Predicted decrease of the deviance.
    pub(crate) gain: f64,
    /// Predicted rms tip displacement, metres.
    pub(crate) size_m: f64,
}

/// The best prediction of each candidate, best first.
pub(crate) fn best_of_each(mut predictions: Vec<LinearPrediction>) -> Vec<LinearPrediction> {
    predictions.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let mut listed = BTreeSet::new();
    predictions.retain(|prediction| listed.insert(prediction.member.candidate));
    predictions
}

/// A residual that is screened.
pub(crate) struct ScreenedResidual<'a> {
    pub(crate) noise: &'a Ar1Noise,
    /// Three values a sample, metres.
    pub(crate) residual_m: &'a [f64],
}

/// The whitened residual of a fit, with all free parameters.
pub(crate) struct LinearScreen<'a> {
    candidates: &'a [CandidateEffect],
    samples: Samples,
    noise: Ar1Noise,
    /// Whitened residual.
    residual: DVector<f64>,
    /// Whitened columns of free parameters with the Cholesky factor of their information, if it
    /// exists.
    free: Option<(DMatrix<f64>, Cholesky<f64, Dyn>)>,
}

impl<'a> LinearScreen<'a> {
    /// `fitted_columns`: Jacobian of the parameters fitted so far.
    pub(crate) fn new(
        candidates: &'a [CandidateEffect],
        samples: &Samples,
        nuisances: &Nuisances,
        ScreenedResidual { noise, residual_m }: ScreenedResidual,
        fitted_columns: &DMatrix<f64>,
    ) -> LinearScreen<'a> {
        let free = noise.whitened(samples, &nuisances.with(fitted_columns));
        let mut normal = nuisances.information(&free);
        // A held parameter has a zero column.
        (nuisances.columns.ncols()..free.ncols()).for_each(|k| normal[(k, k)] += 1e-12);
        let free = Cholesky::new(normal).filter(|_| free.ncols() > 0).map(|factor| (free, factor));
        let residual = DVector::from_vec(noise.whiten(samples, residual_m));
        LinearScreen { candidates, samples: samples.clone(), noise: *noise, residual, free }
    }

    /// Predictions within the validity of their sensitivities, in the order of the `sensitivities`.
    pub(crate) fn predictions(&self, sensitivities: &[Sensitivity]) -> Vec<LinearPrediction> {
        let mut predictions = self.predictions_at_any_step(sensitivities);
        predictions.retain(|prediction| VALID_STEPS.contains(&prediction.share));
        predictions
    }

    /// The same without a check of validity.
    pub(crate) fn predictions_at_any_step(
        &self,
        sensitivities: &[Sensitivity],
    ) -> Vec<LinearPrediction> {
        sensitivities
            .iter()
            .enumerate()
            .filter_map(|(number, sensitivity)| self.prediction(number, sensitivity))
            .collect()
    }

    /// Remaining whitened sum of squares after a tip change `change_m` (three values a sample) and
    /// a fit of the free parameters.
    pub(crate) fn residual_square(&self, change_m: &[f64]) -> f64 {
        self.square_beyond_free(
            &(&self.residual - DVector::from_vec(self.noise.whiten(&self.samples, change_m))),
        )
    }

    /// Sum of squares of a whitened residual that free parameters cannot explain.
    fn square_beyond_free(&self, residual: &DVector<f64>) -> f64 {
        let explained = self.free.as_ref().map_or(0.0, |(free, factor)| {
            let along = free.tr_mul(residual);
            along.dot(&factor.solve(&along))
        });
        residual.norm_squared() - explained
    }

    fn prediction(&self, number: usize, sensitivity: &Sensitivity) -> Option<LinearPrediction> {
        let candidate = &self.candidates[sensitivity.candidate];
        if let Some(step) = sensitivity.step.as_ref().filter(|_| candidate.is_scanned()) {
            return self.prediction_at_step(number, sensitivity, step);
        }
        let columns = self.noise.whitened(&self.samples, &sensitivity.columns);
        // Information on the sizes with all free parameters integrated out (Schur complement).
        let mut information = columns.tr_mul(&columns);
        if let Some((free, factor)) = &self.free {
            let shared = free.tr_mul(&columns);
            information -= shared.tr_mul(&factor.solve(&shared));
        }
        // Directions that nuisance and fitted parameters explain equally well are excluded.
        let floor = 1e-9 * columns.norm_squared();
        (0..information.nrows()).for_each(|k| information[(k, k)] += floor);
        // The residual is already orthogonal to the free parameters, so no Schur term is due here.
        let right = columns.tr_mul(&self.residual);
        let sizes = Cholesky::new(information)?.solve(&right);
        let share = sensitivity
            .step
            .as_ref()
            .map_or(1.0, |step| share_of(candidate, step, sizes.as_slice()));
        let values = within(
            candidate,
            &sensitivity.null,
            &candidate.with_sizes(&sensitivity.null, sizes.as_slice()),
        )?;
        let size_m = rms_m((&sensitivity.columns * &sizes).as_slice());
        let member = SetMember { candidate: sensitivity.candidate, values };
        Some(LinearPrediction {
            member,
            sensitivity: number,
            share,
            gain: self.gain(right.dot(&sizes)),
            size_m,
        })
    }

    /// The same for scanned candidates, at the step itself: a fraction of it would be another
    /// effect.
    fn prediction_at_step(
        &self,
        number: usize,
        sensitivity: &Sensitivity,
        step: &[f64],
    ) -> Option<LinearPrediction> {
        let candidate = &self.candidates[sensitivity.candidate];
        let values = candidate.with_sizes(&sensitivity.null, step);
        candidate.effect(&values)?;
        let change_m = &sensitivity.columns * DVector::from_column_slice(step);
        let explains =
            self.square_beyond_free(&self.residual) - self.residual_square(change_m.as_slice());
        let member = SetMember { candidate: sensitivity.candidate, values };
        let size_m = rms_m(change_m.as_slice());
        Some(LinearPrediction {
            member,
            sensitivity: number,
            share: 1.0,
            gain: self.gain(explains),
            size_m,
        })
    }

    /// Decrease of the deviance if this part of the squares is explained.
    fn gain(&self, explains: f64) -> f64 {
        let squares = self.residual.norm_squared();
        // Profiled over the noise's size: n ln of the ratio of squares.
        self.residual.len() as f64
            * (squares / (squares - explains.clamp(0.0, 0.999_999 * squares))).ln()
    }
}

/// Projection of `sizes` on `step`, in probes.
fn share_of(candidate: &CandidateEffect, step: &[f64], sizes: &[f64]) -> f64 {
    let weights: Vec<f64> =
        candidate.sizes().into_iter().map(|size| candidate.probe(size).powi(-2)).collect();
    let product = |a: &[f64], b: &[f64]| -> f64 {
        a.iter().zip(b).zip(&weights).map(|((a, b), weight)| a * b * weight).sum()
    };
    product(step, sizes) / product(step, step)
}

/// `values`, or values between them and `null` in the valid range; none in an invalid direction.
fn within(candidate: &CandidateEffect, null: &[f64], values: &[f64]) -> Option<Vec<f64>> {
    let between = |share: f64| -> Vec<f64> {
        null.iter().zip(values).map(|(n, v)| n + share * (v - n)).collect()
    };
    // A prediction beyond the range still shows the direction.
    [1.0, 0.5, 0.25, 0.1].into_iter().map(between).find(|values| candidate.effect(values).is_some())
}
