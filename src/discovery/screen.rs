//! A first look: how much of what is left each hypothesis would explain if the tip answered to it linearly.

use std::collections::BTreeSet;

use nalgebra::{Cholesky, DMatrix, DVector};

use super::hypothesis::{Hypothesis, Member};
use super::nuisance::{Explained, Nuisances};
use super::responses::Response;
use super::samples::{Samples, rms_m};

/// A look far out is right for changes between these shares of its own.
pub(super) const ALIKE: std::ops::Range<f64> = 0.3..2.0;

/// What a variant of a hypothesis promises.
#[derive(Clone, Debug)]
pub(super) struct Promise {
    /// The hypothesis with the values that fit best.
    pub(super) member: Member,
    /// Number of the answer that it was seen by.
    pub(super) response: usize,
    /// Expected fall of the deviance.
    pub(super) gain: f64,
    /// How far the hypothesis moves the tip, root mean square, metres.
    pub(super) size_m: f64,
}

/// The best promise of each hypothesis, best first.
pub(super) fn best_of_each(mut promises: Vec<Promise>) -> Vec<Promise> {
    promises.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let mut seen = BTreeSet::new();
    promises.retain(|promise| seen.insert(promise.member.hypothesis));
    promises
}

/// What the variants promise for the residual behind `explained`, those that may help, in their order. `held`: answers to
/// the parameters that are fitted already and will be again.
pub(super) fn screen(
    hypotheses: &[Hypothesis],
    responses: &[Response],
    samples: &Samples,
    nuisances: &Nuisances,
    explained: &Explained,
    held: &DMatrix<f64>,
) -> Vec<Promise> {
    let noise = &explained.noise;
    let white = |matrix: &DMatrix<f64>| {
        let mut out = matrix.clone();
        out.column_iter_mut().for_each(|mut column| {
            let values = noise.whiten(samples, column.as_slice());
            column.copy_from_slice(&values);
        });
        out
    };
    let left = DVector::from_vec(noise.whiten(samples, &explained.left_m));
    let squares = left.norm_squared();
    let free = nuisances.columns.ncols();
    let mut known = nuisances.whitened(samples, noise).resize_horizontally(free + held.ncols(), 0.0);
    known.columns_mut(free, held.ncols()).copy_from(&white(held));
    let mut normal = known.tr_mul(&known);
    // What is held at zero has no answer.
    (free..known.ncols()).for_each(|k| normal[(k, k)] += 1e-12);
    let mut block = normal.view_mut((0, 0), (free, free));
    block += &nuisances.precision;
    let factor = Cholesky::new(normal);
    let promise = |(number, response): (usize, &Response)| -> Option<Promise> {
        let hypothesis = &hypotheses[response.hypothesis];
        let columns = white(&response.columns);
        let mut own = columns.tr_mul(&columns);
        if let Some(factor) = factor.as_ref().filter(|_| known.ncols() > 0) {
            let shared = known.tr_mul(&columns);
            own -= shared.tr_mul(&factor.solve(&shared));
        }
        // What the nuisances and the fitted parameters can do as well is not seen.
        let floor = 1e-9 * columns.norm_squared();
        (0..own.nrows()).for_each(|k| own[(k, k)] += floor);
        let right = columns.tr_mul(&left);
        let sizes = Cholesky::new(own)?.solve(&right);
        if response.step.as_ref().is_some_and(|step| !ALIKE.contains(&share_of(hypothesis, step, sizes.as_slice()))) {
            return None;
        }
        let steps: Vec<(usize, f64)> = hypothesis.sizes().into_iter().zip(sizes.iter().copied()).collect();
        let values = steps.iter().fold(response.null.clone(), |at, &(size, step)| hypothesis.moved(&at, size, step));
        let values = within(hypothesis, &response.null, &values)?;
        let explains = right.dot(&sizes).clamp(0.0, 0.999_999 * squares);
        let size_m = rms_m((&response.columns * &sizes).as_slice());
        let gain = left.len() as f64 * (squares / (squares - explains)).ln();
        Some(Promise { member: Member { hypothesis: response.hypothesis, values }, response: number, gain, size_m })
    };
    responses.iter().enumerate().filter_map(promise).collect()
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
