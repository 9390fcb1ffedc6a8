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

/// What is looked for far out.
struct Far<'a> {
    study: &'a Study<'a>,
    /// Where the coarse model as given has the tip.
    played: Vec<f64>,
    /// How far the tip is to be moved, root mean square, metres.
    left_m: f64,
}

impl Study<'_> {
    /// Answers to each hypothesis of one size, in both directions, where it would move the tip as far as the residual
    /// that `null` leaves if it went on as in `responses`; of each the variant that `promises` has, or the first one if
    /// none: a little of an effect may promise nothing where much of it does. Those whose answer rises and falls are
    /// looked at everywhere (a delay hardly shows until the command acts after the tracker has looked).
    pub(super) fn farther(&self, null: &Fitted, promises: &[Promise], responses: &[Response]) -> Vec<Response> {
        let Some(played) = tips(self.coarse, &[], self.samples) else { return Vec::new() };
        let far = Far { study: self, played, left_m: rms_m(&null.explained.left_m) };
        let promised = promises.iter().map(|promise| &responses[promise.response]);
        let mut seen = vec![false; self.hypotheses.len()];
        let each: Vec<&Response> = promised
            .chain(responses)
            .filter(|response| !std::mem::replace(&mut seen[response.hypothesis], true))
            .filter(|response| response.columns.ncols() == 1)
            .collect();
        let looks = |response: &&Response| {
            let scan = self.hypotheses[response.hypothesis].scan();
            if scan.is_empty() {
                [1.0, -1.0].into_par_iter().flat_map(|sign| far.outward(response, sign)).collect::<Vec<Response>>()
            } else {
                scan.into_par_iter().filter_map(|step| far.look(response, step)).map(|(found, _)| found).collect()
            }
        };
        each.par_iter().flat_map(looks).collect()
    }
}

impl Far<'_> {
    /// The answer to so much of a hypothesis, over its size, and how far it moves the tip; none where it cannot be played.
    fn look(&self, response: &Response, step: f64) -> Option<(Response, f64)> {
        let hypothesis = &self.study.hypotheses[response.hypothesis];
        let effect = hypothesis.effect(&hypothesis.moved(&response.null, hypothesis.sizes()[0], step))?;
        let there = tips(self.study.coarse, &[effect], self.study.samples)?;
        let change: Vec<f64> = there.iter().zip(&self.played).map(|(there, here)| there - here).collect();
        let columns = DMatrix::from_column_slice(change.len(), 1, &change) / step;
        Some((Response { columns, step: Some(step), ..response.clone() }, rms_m(&change)))
    }

    /// Looks on the way to where the tip is moved far enough. Each is an answer: where that is far from even, the last one
    /// may say least.
    fn outward(&self, response: &Response, sign: f64) -> Vec<Response> {
        let hypothesis = &self.study.hypotheses[response.hypothesis];
        let farthest = FARTHEST * hypothesis.probe(hypothesis.sizes()[0]).abs();
        let mut size = farthest.min(self.left_m / rms_m(response.columns.as_slice()).max(f64::MIN_POSITIVE));
        // Known to be too little and too much.
        let (mut little, mut much) = (0.0, f64::INFINITY);
        let mut found = Vec::new();
        for _ in 0..LOOKS {
            let Some((seen, moved_m)) = self.look(response, sign * size) else {
                much = size;
                size = 0.5 * (little + much);
                continue;
            };
            found.push(seen);
            let wanted = self.left_m / moved_m.max(f64::MIN_POSITIVE);
            if NEAR_ENOUGH.contains(&wanted) || (wanted > 1.0 && size >= farthest) {
                break;
            }
            *(if wanted > 1.0 { &mut little } else { &mut much }) = size;
            let next = farthest.min(size * wanted.clamp(0.25, 4.0));
            size = if next > little && next < much { next } else { 0.5 * (little + much) };
        }
        found
    }
}
