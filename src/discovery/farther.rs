//! A second look at each hypothesis, as far out as the residual is large. The tip's answer to a little of an effect may
//! say nothing of its answer to much of it, or to the other direction: a softer rod sags until tendons are taut, a
//! stiffer one does not.
//!
//! The trials where most is left show which of the looks may matter; those alone are played in all of them.

use std::ops::Range;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::hypothesis::effects;
use super::nuisance::{Explained, Nuisances};
use super::play::tips;
use super::refit::{Fitted, Study};
use super::responses::Response;
use super::samples::{Samples, rms_m};
use super::screen::{Promise, screen};

/// Farther than this, in usual sizes, no one looks.
const FARTHEST: f64 = 8.0;
/// Plays at most to find where an effect moves the tip as far as the residual is large.
const LOOKS: usize = 5;
/// Between these shares of the residual that is far enough.
const NEAR_ENOUGH: Range<f64> = 0.5..2.0;
/// Trials that are looked at first.
const SHOWN: usize = 2;
/// A look is followed up when it promises there this share of what the best one does, or all but so much.
const WORTH_SHARE: f64 = 0.2;
const WORTH_SLACK: f64 = 10.0;

impl Study<'_> {
    /// Answers to each hypothesis of one size beside those of `base`, in both directions, where it would move the tip as
    /// far as the residual that `base` leaves if it went on as in `responses`; of each the variant that `promises` has, or
    /// the first one if none: a little of an effect may promise nothing where much of it does. Those whose answer rises
    /// and falls are looked at everywhere (a delay hardly shows until the command acts after the tracker has looked).
    pub(super) fn farther(&self, base: &Fitted, promises: &[Promise], responses: &[Response]) -> Vec<Response> {
        let all = Far { study: self, base, samples: self.samples.clone(), rows: (0..3 * self.samples.len()).collect() };
        let some = all.most_telling();
        let (Some(here), Some(there)) = (some.played(&[]), all.played(&[])) else { return Vec::new() };
        let known: Vec<Response> = responses.iter().map(|response| some.part(response)).collect();
        let promised = promises.iter().map(|promise| &known[promise.response]);
        let mut seen = vec![false; self.hypotheses.len()];
        base.members.iter().for_each(|member| seen[member.hypothesis] = true);
        let begun: Vec<&Response> = promised
            .chain(known.iter().filter(|response| response.step.is_none()))
            .filter(|response| !std::mem::replace(&mut seen[response.hypothesis], true))
            .filter(|response| response.columns.ncols() == 1)
            .collect();
        let looks: Vec<Response> = begun.into_par_iter().flat_map(|response| some.looks(response, &here)).collect();
        let worth = some.worth(looks, &known);
        worth.into_par_iter().filter_map(|look| all.look(&look, &there, look.step?)).map(|(found, _)| found).collect()
    }
}

/// What is looked for far out, in some of the samples.
struct Far<'a> {
    study: &'a Study<'a>,
    /// What is known to be missing.
    base: &'a Fitted,
    samples: Samples,
    /// Their numbers among all of the study, three a sample.
    rows: Vec<usize>,
}

impl Far<'_> {
    /// The same in the trials where most is left.
    fn most_telling(&self) -> Far<'_> {
        let ranges = self.samples.ranges();
        let rows = |trial: usize| 3 * ranges[trial].start..3 * ranges[trial].end;
        let left =
            |trial: usize| -> f64 { self.base.explained.left_m[rows(trial)].iter().map(|left| left * left).sum() };
        let mut trials: Vec<usize> = (0..ranges.len()).collect();
        trials.sort_by(|&a, &b| left(b).total_cmp(&left(a)));
        trials.truncate(SHOWN);
        let samples = self.samples.of_trials(&trials);
        Far { study: self.study, base: self.base, samples, rows: trials.into_iter().flat_map(rows).collect() }
    }

    /// An answer in these samples.
    fn part(&self, response: &Response) -> Response {
        Response { columns: response.columns.select_rows(&self.rows), ..response.clone() }
    }

    /// What is left in these samples.
    fn left_m(&self) -> Vec<f64> {
        self.rows.iter().map(|&row| self.base.explained.left_m[row]).collect()
    }

    /// Where the coarse model with the members of the base and `more` has the tip.
    fn played(&self, more: &[crate::effects::EffectSpec]) -> Option<Vec<f64>> {
        let known = effects(self.study.hypotheses, &self.base.members)?;
        tips(self.study.coarse, &[&known, more].concat(), &self.samples)
    }

    /// The answer to so much of a hypothesis, over its size, and how far it moves the tip from where it is `here`; none where
    /// it cannot be played.
    fn look(&self, response: &Response, here: &[f64], step: f64) -> Option<(Response, f64)> {
        let hypothesis = &self.study.hypotheses[response.hypothesis];
        let effect = hypothesis.effect(&hypothesis.moved(&response.null, hypothesis.sizes()[0], step))?;
        let change: Vec<f64> = self.played(&[effect])?.iter().zip(here).map(|(there, here)| there - here).collect();
        let columns = DMatrix::from_column_slice(change.len(), 1, &change) / step;
        Some((Response { columns, step: Some(step), ..response.clone() }, rms_m(&change)))
    }

    /// All looks at a hypothesis, of which a little answers with `response`.
    fn looks(&self, response: &Response, here: &[f64]) -> Vec<Response> {
        let scan = self.study.hypotheses[response.hypothesis].scan();
        if scan.is_empty() {
            let left_m = rms_m(&self.left_m());
            return [1.0, -1.0].into_par_iter().flat_map(|sign| self.outward(response, here, left_m, sign)).collect();
        }
        let seen = scan.into_par_iter().filter_map(|step| self.look(response, here, step));
        seen.map(|(found, _)| found).collect()
    }

    /// Looks on the way to where the tip is moved far enough. Each is an answer: where that is far from even, the last one
    /// may say least.
    fn outward(&self, response: &Response, here: &[f64], left_m: f64, sign: f64) -> Vec<Response> {
        let hypothesis = &self.study.hypotheses[response.hypothesis];
        let farthest = FARTHEST * hypothesis.probe(hypothesis.sizes()[0]).abs();
        let mut size = farthest.min(left_m / rms_m(response.columns.as_slice()).max(f64::MIN_POSITIVE));
        // Known to be too little and too much.
        let (mut little, mut much) = (0.0, f64::INFINITY);
        let mut found = Vec::new();
        for _ in 0..LOOKS {
            let Some((seen, moved_m)) = self.look(response, here, sign * size) else {
                much = size;
                size = 0.5 * (little + much);
                continue;
            };
            found.push(seen);
            let wanted = left_m / moved_m.max(f64::MIN_POSITIVE);
            if NEAR_ENOUGH.contains(&wanted) || (wanted > 1.0 && size >= farthest) {
                break;
            }
            *(if wanted > 1.0 { &mut little } else { &mut much }) = size;
            let next = farthest.min(size * wanted.clamp(0.25, 4.0));
            size = if next > little && next < much { next } else { 0.5 * (little + much) };
        }
        found
    }

    /// Those of the looks that promise enough in these samples, beside what is `known`.
    fn worth(&self, looks: Vec<Response>, known: &[Response]) -> Vec<Response> {
        let study = self.study;
        let explained = Explained { left_m: self.left_m(), ..self.base.explained.clone() };
        let nuisances: Nuisances = study.nuisances.in_rows(&self.rows);
        let held = self.base.jacobian.select_rows(&self.rows);
        let promises =
            |responses: &[Response]| screen(study.hypotheses, responses, &self.samples, &nuisances, &explained, &held);
        let found = promises(&looks);
        let best = found.iter().chain(&promises(known)).map(|promise| promise.gain).fold(0.0, f64::max);
        let least = (WORTH_SHARE * best).min(best - WORTH_SLACK);
        let kept = found.into_iter().filter(|promise| promise.gain >= least);
        kept.map(|promise| looks[promise.response].clone()).collect()
    }
}
