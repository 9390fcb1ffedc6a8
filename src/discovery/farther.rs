//! A second look at each hypothesis, as far out as the residual is large. The tip's answer to a little of an effect may
//! say nothing of its answer to much of it, or to the other direction: a softer rod sags until tendons are taut, a
//! stiffer one does not.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::play::tips;
use super::refit::{Fitted, Study};
use super::responses::Response;
use super::samples::rms_m;
use super::screen::Promise;

/// Farther than this, in usual sizes, no one looks.
const FARTHEST: f64 = 8.0;
/// Plays at most to find where an effect moves the tip as far as the residual is large.
const LOOKS: usize = 5;
/// Between these shares of the residual that is far enough.
const NEAR_ENOUGH: std::ops::Range<f64> = 0.5..2.0;

impl Study<'_> {
    /// Answers to each hypothesis of one size, in both directions, where it would move the tip as far as the residual
    /// that `null` leaves if it went on as in `responses`; of each the variant that `promises` has, or the first one if
    /// none: a little of an effect may promise nothing where much of it does (a delay that ends within the sample).
    /// Every look on the way is an answer: where the tip's answer is far from even, the last one may say least.
    pub(super) fn farther(&self, null: &Fitted, promises: &[Promise], responses: &[Response]) -> Vec<Response> {
        let Some(played) = tips(self.coarse, &[], self.samples) else { return Vec::new() };
        let left_m = rms_m(&null.explained.left_m);
        let promised = promises.iter().map(|promise| &responses[promise.response]);
        let mut seen = vec![false; self.hypotheses.len()];
        let ways: Vec<(&Response, f64)> = promised
            .chain(responses)
            .filter(|response| !std::mem::replace(&mut seen[response.hypothesis], true))
            .filter(|response| response.columns.ncols() == 1)
            .flat_map(|response| [(response, 1.0), (response, -1.0)])
            .collect();
        let look = |(response, sign): (&Response, f64)| {
            let hypothesis = &self.hypotheses[response.hypothesis];
            let size = hypothesis.sizes()[0];
            let farthest = FARTHEST * hypothesis.probe(size).abs();
            let mut step = farthest.min(left_m / rms_m(response.columns.as_slice()).max(f64::MIN_POSITIVE));
            // Steps known to be too short and too far.
            let (mut short, mut far) = (0.0, f64::INFINITY);
            let mut found = Vec::new();
            for _ in 0..LOOKS {
                let effect = hypothesis.effect(&hypothesis.moved(&response.null, size, sign * step));
                let Some(there) = effect.and_then(|effect| tips(self.coarse, &[effect], self.samples)) else {
                    far = step;
                    step = 0.5 * (short + step);
                    continue;
                };
                let change: Vec<f64> = there.iter().zip(&played).map(|(there, here)| there - here).collect();
                let columns = DMatrix::from_column_slice(change.len(), 1, &change) / (sign * step);
                found.push(Response { columns, step: Some(sign * step), ..response.clone() });
                let wanted = left_m / rms_m(&change).max(f64::MIN_POSITIVE);
                if NEAR_ENOUGH.contains(&wanted) || (wanted > 1.0 && step >= farthest) {
                    break;
                }
                if wanted > 1.0 {
                    short = step
                } else {
                    far = step
                }
                let next = farthest.min(step * wanted.clamp(0.25, 4.0));
                step = if next > short && next < far { next } else { 0.5 * (short + far) };
            }
            found
        };
        ways.into_par_iter().flat_map(look).collect()
    }
}
