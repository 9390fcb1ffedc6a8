//! A second look at each hypothesis, as far out as the residual is large. The tip's answer to a little of an effect may
//! say nothing of its answer to much of it, or to the other direction: a softer rod sags until tendons are taut, a
//! stiffer one does not.
//!
//! The trials where most is left show which of the looks may matter; those alone are played in all of them.

use std::ops::Range;

use nalgebra::DVector;
use rayon::prelude::*;

use super::screening::{ALIKE, Screen, best_of_each};
use crate::discovery::fit::candidate::{Hypothesis, Member, effects};
use crate::discovery::fit::gauss_newton::{Fitted, Study};
use crate::discovery::fit::sensitivities::{Response, responses};
use crate::discovery::fit::simulate::tips;
use crate::discovery::recording::samples::{Samples, rms_m};

/// Farther than this, in usual sizes, no one looks.
const FARTHEST: f64 = 8.0;
/// Plays at most to find where an effect moves the tip as far as the residual is large.
const LOOKS: usize = 5;
/// Between these shares of the residual that is far enough.
const NEAR_ENOUGH: Range<f64> = 0.5..2.0;
/// Looks at most nearer to where the best of those promises to fit, and how near to that is near enough.
const NEARER: usize = 3;
const THERE: f64 = 0.2;
/// How often the steps of a scan are halved about its best one: a delay is seen within a quarter of a drive's time.
const HALVED: usize = 2;
/// Trials that are looked at first.
const SHOWN: usize = 2;
/// A look is followed up when it promises there this share of what the best one does, or all but so much.
const WORTH_SHARE: f64 = 0.2;
const WORTH_SLACK: f64 = 10.0;

impl Study<'_> {
    /// Answers to each hypothesis beside those of `base`, in both directions, where it would move the tip as far as the
    /// residual that `base` leaves if it went on as a little of it does, and from there where it fits; of each the variant
    /// that promises most, or the first one if none: a little of an effect may promise nothing where much of it does.
    /// Those whose answer rises and falls are looked at everywhere (a delay hardly shows until the command acts after the
    /// tracker has looked).
    pub(crate) fn farther(&self, base: &Fitted, responses: &[Response]) -> Vec<Response> {
        let all = Far::new(self, base, &(0..self.samples.trials.len()).collect::<Vec<usize>>());
        let some = Far::new(self, base, &self.most_telling(base));
        let (Some(here), Some(there)) = (some.played(&[]), all.played(&[])) else { return Vec::new() };
        let beside = some.beside(&|_| true);
        let (known, promises) = if beside.is_empty() {
            (responses.iter().map(|response| some.part(response)).collect(), self.promises(base, &[], responses))
        } else {
            let promises = best_of_each(some.screen.promises(&beside));
            (beside, promises)
        };
        let little = |of: &Response| known.iter().find(|response| response.is_little_of(of));
        let promised = promises.iter().filter_map(|promise| little(&known[promise.response]));
        let mut seen = vec![false; self.hypotheses.len()];
        base.members.iter().for_each(|member| seen[member.hypothesis] = true);
        let begun: Vec<&Response> = promised
            .chain(known.iter().filter_map(little))
            .filter(|response| self.open[response.hypothesis])
            .filter(|response| !std::mem::replace(&mut seen[response.hypothesis], true))
            .collect();
        let looks: Vec<Response> = begun.into_par_iter().flat_map(|response| some.looks(response, &here)).collect();
        let worth = some.worth(looks, &known);
        // A look corrects the answer in its own direction; the others are right beside the base only.
        let wide = |hypothesis: &Hypothesis| {
            let of = |look: &Response| std::ptr::eq(hypothesis, &self.hypotheses[look.hypothesis]);
            hypothesis.sizes().len() > 1 && worth.iter().any(of)
        };
        let beside = all.beside(&wide);
        let everywhere = |look: &Response| {
            let little = beside.iter().chain(responses).find(|response| response.is_little_of(look))?;
            Some(all.look(little, &there, look.step.as_ref()?)?.0)
        };
        worth.par_iter().filter_map(everywhere).collect()
    }

    /// The trials where most is left.
    fn most_telling(&self, base: &Fitted) -> Vec<usize> {
        let ranges = self.samples.ranges();
        let left = |trial: usize| -> f64 {
            base.explained.left_m[3 * ranges[trial].start..3 * ranges[trial].end].iter().map(|left| left * left).sum()
        };
        let mut trials: Vec<usize> = (0..ranges.len()).collect();
        trials.sort_by(|&a, &b| left(b).total_cmp(&left(a)));
        trials.truncate(SHOWN);
        trials
    }
}

/// A look at one step of a scan, and the squares that it leaves.
struct Tried {
    step: f64,
    left: f64,
    look: Response,
}

/// What is looked for far out, in some of the trials.
struct Far<'a> {
    study: &'a Study<'a>,
    /// What is known to be missing.
    base: &'a Fitted,
    samples: Samples,
    /// Their numbers among all of the study, three a sample.
    rows: Vec<usize>,
    /// What is left in them, metres.
    left_m: Vec<f64>,
    screen: Screen<'a>,
}

impl<'a> Far<'a> {
    fn new(study: &'a Study<'a>, base: &'a Fitted, trials: &[usize]) -> Far<'a> {
        let ranges = study.samples.ranges();
        let rows: Vec<usize> =
            trials.iter().flat_map(|&trial| 3 * ranges[trial].start..3 * ranges[trial].end).collect();
        let samples = study.samples.of_trials(trials);
        let left_m: Vec<f64> = rows.iter().map(|&row| base.explained.left_m[row]).collect();
        let nuisances = study.nuisances.in_rows(&rows);
        let held = base.jacobian.select_rows(&rows);
        let screen = Screen::new(study.hypotheses, &samples, &nuisances, (&base.explained.noise, &left_m), &held);
        Far { study, base, samples, rows, left_m, screen }
    }

    /// An answer in these samples.
    fn part(&self, response: &Response) -> Response {
        Response { columns: response.columns.select_rows(&self.rows), ..response.clone() }
    }

    /// Answers to a little of those hypotheses beside the members of the base, where there are any: with those the rod may
    /// hang on other tendons.
    fn beside(&self, asked: &(dyn Fn(&Hypothesis) -> bool + Sync)) -> Vec<Response> {
        let (study, members) = (self.study, &self.base.members);
        let asked = |hypothesis: &Hypothesis| !members.is_empty() && asked(hypothesis);
        responses(study.coarse, study.hypotheses, members, &asked, &self.samples)
    }

    /// Where the coarse model with the members of the base and `more` has the tip.
    fn played(&self, more: &[crate::effects::EffectSpec]) -> Option<Vec<f64>> {
        let known = effects(self.study.hypotheses, &self.base.members)?;
        tips(self.study.coarse, &[&known, more].concat(), &self.samples)
    }

    /// `response` corrected by what so much of it does (Broyden's update, in units of the probes), and how far that moves
    /// the tip from where it is `here`; none where it cannot be played.
    fn look(&self, response: &Response, here: &[f64], step: &[f64]) -> Option<(Response, f64)> {
        let hypothesis = &self.study.hypotheses[response.hypothesis];
        let sizes = hypothesis.sizes();
        let effect = hypothesis.effect(&hypothesis.sized(&response.null, step))?;
        let change: Vec<f64> = self.played(&[effect])?.iter().zip(here).map(|(there, here)| there - here).collect();
        let by = DVector::from_column_slice(step);
        let along = DVector::from_iterator(
            step.len(),
            sizes.iter().zip(step).map(|(&size, by)| by / hypothesis.probe(size).powi(2)),
        );
        let missed = DVector::from_column_slice(&change) - &response.columns * &by;
        let columns = &response.columns + missed * along.transpose() / along.dot(&by);
        Some((Response { columns, step: Some(step.to_vec()), ..response.clone() }, rms_m(&change)))
    }

    /// All looks at a hypothesis, of which a little answers with `response`.
    fn looks(&self, response: &Response, here: &[f64]) -> Vec<Response> {
        let hypothesis = &self.study.hypotheses[response.hypothesis];
        if hypothesis.rises_and_falls() {
            let scan = hypothesis.scan();
            let look = |&step: &f64| {
                let (look, _) = self.look(response, here, &[step])?;
                Some(Tried { step, left: self.screen.left_by((&look.columns * step).as_slice()), look })
            };
            return Self::between(scan.par_iter().filter_map(look).collect(), &scan, &look);
        }
        let Some(direction) = self.direction(response) else { return Vec::new() };
        let both = [1.0, -1.0].into_par_iter().map(|sign| sign * &direction);
        let looks = both.flat_map(|direction| self.outward(response, here, &direction)).collect();
        self.nearer(looks, here)
    }

    /// The looks at the steps of a `scan`, with more of them to both sides of the one that fits best: what rises and falls may
    /// do so within a step.
    fn between(mut tried: Vec<Tried>, scan: &[f64], look: &dyn Fn(&f64) -> Option<Tried>) -> Vec<Response> {
        let mut apart = scan.windows(2).map(|two| two[1] - two[0]).fold(scan[0], f64::min);
        for _ in 0..HALVED {
            apart *= 0.5;
            let Some(best) = tried.iter().min_by(|a, b| a.left.total_cmp(&b.left)) else { break };
            let beside = [best.step - apart, best.step + apart];
            tried.extend(beside.iter().filter_map(look));
        }
        tried.into_iter().map(|tried| tried.look).collect()
    }

    /// Where a hypothesis points: at what is promised by a little of it, if it has several sizes.
    fn direction(&self, response: &Response) -> Option<DVector<f64>> {
        let hypothesis = &self.study.hypotheses[response.hypothesis];
        match hypothesis.sizes()[..] {
            [size] => Some(DVector::from_element(1, hypothesis.probe(size).abs())),
            _ => Some(self.step(&self.screen.promises(std::slice::from_ref(response)).pop()?.member, response)),
        }
    }

    /// The change of the sizes from nothing to `member`.
    fn step(&self, member: &Member, response: &Response) -> DVector<f64> {
        let hypothesis = &self.study.hypotheses[response.hypothesis];
        let each = hypothesis.sizes().into_iter().map(|size| hypothesis.step(&response.null, &member.values, size));
        DVector::from_vec(each.collect())
    }

    /// A step in units of the probes.
    fn in_probes(&self, response: &Response, step: &DVector<f64>) -> DVector<f64> {
        let hypothesis = &self.study.hypotheses[response.hypothesis];
        let each = hypothesis.sizes().into_iter().zip(step.iter()).map(|(size, by)| by / hypothesis.probe(size));
        DVector::from_vec(each.collect())
    }

    /// Looks on the way to where the tip is moved far enough. Each is an answer: where that is far from even, the last one
    /// may say least.
    fn outward(&self, response: &Response, here: &[f64], direction: &DVector<f64>) -> Vec<Response> {
        let left_m = rms_m(&self.left_m);
        let farthest = FARTHEST / self.in_probes(response, direction).amax().max(f64::MIN_POSITIVE);
        let usual_m = rms_m((&response.columns * direction).as_slice());
        let mut size = farthest.min(left_m / usual_m.max(f64::MIN_POSITIVE));
        // Known to be too little and too much.
        let (mut little, mut much) = (0.0, f64::INFINITY);
        let mut found = Vec::new();
        for _ in 0..LOOKS {
            let Some((seen, moved_m)) = self.look(response, here, (size * direction).as_slice()) else {
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

    /// The looks, with more of them where the best promises that it fits, as long as the newest is the best.
    fn nearer(&self, mut looks: Vec<Response>, here: &[f64]) -> Vec<Response> {
        let mut followed = looks.len();
        for _ in 0..NEARER {
            let promises = self.screen.promises_anywhere(&looks).into_iter();
            let Some(best) = promises.max_by(|a, b| a.gain.total_cmp(&b.gain)) else { break };
            let look = &looks[best.response];
            let Some(next) = look.step.as_ref().and_then(|step| self.next(look, step, &best.member)) else { break };
            if std::mem::replace(&mut followed, best.response) == best.response {
                break;
            }
            let Some((seen, _)) = self.look(look, here, next.as_slice()) else { break };
            looks.push(seen);
        }
        looks
    }

    /// Where to look after a look at `step` has promised `best`; none where that is near enough.
    fn next(&self, look: &Response, step: &[f64], best: &Member) -> Option<DVector<f64>> {
        let (there, wanted) = (DVector::from_column_slice(step), self.step(best, look));
        let size = |step: &DVector<f64>| self.in_probes(look, step).norm();
        let most = FARTHEST.min(ALIKE.end * size(&there));
        let wanted = &wanted * (most / size(&wanted).max(f64::MIN_POSITIVE)).min(1.0);
        (size(&(&wanted - there)) >= THERE * size(&wanted)).then_some(wanted)
    }

    /// Those of the looks that promise enough in these samples, beside what is `known`.
    fn worth(&self, looks: Vec<Response>, known: &[Response]) -> Vec<Response> {
        let found = self.screen.promises(&looks);
        let mut rivals = self.screen.promises(known);
        rivals.retain(|promise| self.study.open[promise.member.hypothesis]);
        let best = found.iter().chain(&rivals).map(|promise| promise.gain).fold(0.0, f64::max);
        let least = (WORTH_SHARE * best).min(best - WORTH_SLACK);
        let kept = found.into_iter().filter(|promise| promise.gain >= least);
        kept.map(|promise| looks[promise.response].clone()).collect()
    }
}
