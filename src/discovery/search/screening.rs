//! A first look: how much of what is left each hypothesis would explain if the tip answered to it linearly.

use std::collections::BTreeSet;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::discovery::fit::ar1_noise::Noise;
use crate::discovery::fit::candidate::{Hypothesis, Member};
use crate::discovery::fit::nuisance::Nuisances;
use crate::discovery::fit::sensitivities::Response;
use crate::discovery::recording::samples::{Samples, rms_m};

/// A look far out is right for changes between these shares of its own.
pub(crate) const ALIKE: std::ops::Range<f64> = 0.3..2.0;

/// What a variant of a hypothesis promises.
#[derive(Clone, Debug)]
pub(crate) struct Promise {
    /// The hypothesis with the values that fit best.
    pub(crate) member: Member,
    /// Number of the answer that it was seen by.
    pub(crate) response: usize,
    /// How much of the change that the answer holds for it would be; one for an answer to a little.
    pub(crate) share: f64,
    /// Expected fall of the deviance.
    pub(crate) gain: f64,
    /// How far the hypothesis moves the tip, root mean square, metres.
    pub(crate) size_m: f64,
}

/// The best promise of each hypothesis, best first.
pub(crate) fn best_of_each(mut promises: Vec<Promise>) -> Vec<Promise> {
    promises.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let mut seen = BTreeSet::new();
    promises.retain(|promise| seen.insert(promise.member.hypothesis));
    promises
}

/// The residual behind a fit, with all that is to be free beside whatever is looked at.
pub(crate) struct Screen<'a> {
    hypotheses: &'a [Hypothesis],
    samples: Samples,
    noise: Noise,
    /// What is left, white.
    left: DVector<f64>,
    /// White answers to what is free, with the factor of its information; none where there is no such factor.
    free: Option<(DMatrix<f64>, Cholesky<f64, Dyn>)>,
}

impl<'a> Screen<'a> {
    /// `held`: answers to the parameters that are fitted already and will be again.
    pub(crate) fn new(
        hypotheses: &'a [Hypothesis],
        samples: &Samples,
        nuisances: &Nuisances,
        (noise, left_m): (&Noise, &[f64]),
        held: &DMatrix<f64>,
    ) -> Screen<'a> {
        let known = noise.whitened(samples, &nuisances.with(held));
        let mut normal = nuisances.information(&known);
        // What is held at zero has no answer.
        (nuisances.columns.ncols()..known.ncols()).for_each(|k| normal[(k, k)] += 1e-12);
        let free = Cholesky::new(normal).filter(|_| known.ncols() > 0).map(|factor| (known, factor));
        let left = DVector::from_vec(noise.whiten(samples, left_m));
        Screen { hypotheses, samples: samples.clone(), noise: *noise, left, free }
    }

    /// What the variants promise, those that may help, in the order of the `responses`.
    pub(crate) fn promises(&self, responses: &[Response]) -> Vec<Promise> {
        let mut promises = self.promises_anywhere(responses);
        promises.retain(|promise| ALIKE.contains(&promise.share));
        promises
    }

    /// The same, however far that is from where each was looked at.
    pub(crate) fn promises_anywhere(&self, responses: &[Response]) -> Vec<Promise> {
        responses.iter().enumerate().filter_map(|(number, response)| self.promise(number, response)).collect()
    }

    /// Sum of squares (white) that is left where the tip is moved by `change_m`, three numbers a sample, what is free having
    /// done what it can.
    pub(crate) fn left_by(&self, change_m: &[f64]) -> f64 {
        self.beyond_free(&(&self.left - DVector::from_vec(self.noise.whiten(&self.samples, change_m))))
    }

    /// The squares of a white residual that what is free cannot take.
    fn beyond_free(&self, left: &DVector<f64>) -> f64 {
        let taken = self.free.as_ref().map_or(0.0, |(known, factor)| {
            let along = known.tr_mul(left);
            along.dot(&factor.solve(&along))
        });
        left.norm_squared() - taken
    }

    fn promise(&self, number: usize, response: &Response) -> Option<Promise> {
        let hypothesis = &self.hypotheses[response.hypothesis];
        if let Some(step) = response.step.as_ref().filter(|_| hypothesis.rises_and_falls()) {
            return self.promise_as_it_is(number, response, step);
        }
        let columns = self.noise.whitened(&self.samples, &response.columns);
        let mut own = columns.tr_mul(&columns);
        if let Some((known, factor)) = &self.free {
            let shared = known.tr_mul(&columns);
            own -= shared.tr_mul(&factor.solve(&shared));
        }
        // What the nuisances and the fitted parameters can do as well is not seen.
        let floor = 1e-9 * columns.norm_squared();
        (0..own.nrows()).for_each(|k| own[(k, k)] += floor);
        let right = columns.tr_mul(&self.left);
        let sizes = Cholesky::new(own)?.solve(&right);
        let share = response.step.as_ref().map_or(1.0, |step| share_of(hypothesis, step, sizes.as_slice()));
        let values = within(hypothesis, &response.null, &hypothesis.sized(&response.null, sizes.as_slice()))?;
        let size_m = rms_m((&response.columns * &sizes).as_slice());
        let member = Member { hypothesis: response.hypothesis, values };
        Some(Promise { member, response: number, share, gain: self.gain(right.dot(&sizes)), size_m })
    }

    /// The same for an answer that rises and falls: a part of what was looked at would be something else.
    fn promise_as_it_is(&self, number: usize, response: &Response, step: &[f64]) -> Option<Promise> {
        let hypothesis = &self.hypotheses[response.hypothesis];
        let values = hypothesis.sized(&response.null, step);
        hypothesis.effect(&values)?;
        let change_m = &response.columns * DVector::from_column_slice(step);
        let explains = self.beyond_free(&self.left) - self.left_by(change_m.as_slice());
        let member = Member { hypothesis: response.hypothesis, values };
        let size_m = rms_m(change_m.as_slice());
        Some(Promise { member, response: number, share: 1.0, gain: self.gain(explains), size_m })
    }

    /// Fall of the deviance where so much of the squares that are left is explained.
    fn gain(&self, explains: f64) -> f64 {
        let squares = self.left.norm_squared();
        self.left.len() as f64 * (squares / (squares - explains.clamp(0.0, 0.999_999 * squares))).ln()
    }
}

/// How much of `step` there is in `sizes`, each over what is easily seen of it.
fn share_of(hypothesis: &Hypothesis, step: &[f64], sizes: &[f64]) -> f64 {
    let seen: Vec<f64> = hypothesis.sizes().into_iter().map(|size| hypothesis.probe(size).powi(-2)).collect();
    let product = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).zip(&seen).map(|((a, b), seen)| a * b * seen).sum() };
    product(step, sizes) / product(step, step)
}

/// `values`, or values between them and `null` that are in the effect's range: nothing if it is in the wrong direction.
fn within(hypothesis: &Hypothesis, null: &[f64], values: &[f64]) -> Option<Vec<f64>> {
    let between = |share: f64| -> Vec<f64> { null.iter().zip(values).map(|(n, v)| n + share * (v - n)).collect() };
    [1.0, 0.5, 0.25, 0.1].into_iter().map(between).find(|values| hypothesis.effect(values).is_some())
}
