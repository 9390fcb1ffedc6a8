//! The search for the effects that are missing: one after the other, then each against all others in its place, then
//! without each; then from pairs that this did not lead to.

pub(crate) mod add_effect;
pub(crate) mod forward_step;
pub(crate) mod large_amplitude;
pub(crate) mod pair_step;
pub(crate) mod screening;
pub(crate) mod swap;

use std::collections::BTreeSet;

use super::fit::ar1_noise::Noise;
use super::fit::candidate::{Hypothesis, set_of};
use super::fit::gauss_newton::{Fitted, Study};
use super::fit::sensitivities::Response;
use screening::Promise;

/// How far the search goes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Effects at most.
    pub(super) most_effects: usize,
    /// Score that an effect must add to be taken.
    pub(super) least_score: f64,
    /// Distance that an effect must move the tip, over the noise floor.
    pub(super) least_size: f64,
    /// The same for one effect more, over what those found before it do together.
    pub(super) least_share: f64,
    /// The same in metres, whatever the noise.
    pub(super) least_m: f64,
    /// Sets whose scores are nearer are rivals.
    pub(super) rival_score: f64,
    /// Beside sets of fewer effects every hypothesis is fitted, whatever it promises at a first look.
    pub(super) thorough: usize,
}

/// A set of effects that was fitted, with its score.
#[derive(Clone, Debug)]
pub(super) struct Scored {
    pub(super) fitted: Fitted,
    /// Fall of the deviance since the model as given, less what its parameters and their choice cost.
    pub(super) score: f64,
    /// Whether it is fitted as well as can be.
    pub(super) exact: bool,
}

impl Scored {
    /// Whether it could be the answer instead of `best`: with no more effects, and less than `rival_score` behind.
    pub(super) fn rivals(&self, best: &Scored, rival_score: f64) -> bool {
        self.fitted.members.len() <= best.fitted.members.len() && self.score > best.score - rival_score
    }
}

/// What the search ends with.
pub(super) struct Found {
    /// The best set; empty when nothing is missing.
    pub(super) best: Scored,
    /// The model as given.
    pub(super) null: Scored,
    /// All sets that were fitted.
    pub(super) tried: Vec<Scored>,
    /// What every hypothesis promises at a first look, with the score that it would have.
    pub(super) looked_at: Vec<(Promise, f64)>,
}

/// Rough fits at most, and of them those that are fitted further.
pub(super) const WIDTH: usize = 8;
/// Promises are taken to be right to this share of the best, or to so much.
const PROMISE_SHARE: f64 = 0.7;
const PROMISE_SLACK: f64 = 30.0;
/// A rough fit may be short by this share of what it adds, where it is of sizes alone and where a shape or a place is
/// yet to be found, and by so much.
const SHORT_SHARE: f64 = 0.1;
const SHAPELESS_SHARE: f64 = 0.25;
const SHORT: f64 = 10.0;
/// A first look may be wrong by this share of the size.
const NEARLY: f64 = 0.7;
/// A first look that promises less than this, score and all, is not followed up; nor is a rough fit that is worse than
/// what it was to improve by this and by what makes a rival.
const HOPELESS: f64 = -6.0;

/// A search on its way.
pub(super) struct Search<'s> {
    pub(super) study: &'s Study<'s>,
    pub(super) limits: Limits,
    pub(super) null: Scored,
    /// The tip's answers to the hypotheses.
    pub(super) responses: Vec<Response>,
    /// The sets beside which they were looked at far out.
    looked: BTreeSet<BTreeSet<usize>>,
    pub(super) tried: Vec<Scored>,
}

impl<'s> Search<'s> {
    /// A search for the set of hypotheses that explains the samples best, one that pays for its parameters (extended
    /// Bayesian information criterion, Chen & Chen, Biometrika 95, 2008). None where the model cannot play the samples.
    pub(super) fn new(study: &'s Study<'s>, responses: Vec<Response>, limits: &Limits) -> Option<Search<'s>> {
        let null = Scored { fitted: study.null()?, score: 0.0, exact: true };
        Some(Search { study, limits: *limits, null, responses, looked: BTreeSet::new(), tried: Vec::new() })
    }

    /// The best set as far as promises lead.
    pub(super) fn best(&mut self) -> Scored {
        self.enlarged(self.null.clone())
    }
}

impl Limits {
    /// How far an effect must move the tip beside a set that leaves this noise, metres.
    pub(super) fn least_m(&self, noise: &Noise) -> f64 {
        self.least_m.max(self.least_size * noise.rms_m())
    }
}

impl Study<'_> {
    /// Whether what a first look promises beside `base` may turn out to be worth having.
    pub(super) fn is_worth_fitting(&self, promise: &Promise, base: &Fitted, limits: &Limits) -> bool {
        let least_m = NEARLY * limits.least_m(&base.explained.noise);
        self.promised(promise) > limits.least_score + HOPELESS && promise.size_m > least_m
    }
}

impl Search<'_> {
    /// `best` with more effects, as long as each is worth having.
    pub(super) fn enlarged(&mut self, mut best: Scored) -> Scored {
        // The best that was worth having where the search went elsewhere.
        let mut passed: Option<Scored> = None;
        loop {
            best = match self.step_from(&best) {
                (Some(other), next) => {
                    passed = passed.into_iter().chain(next).max_by(|a, b| self.net(a).total_cmp(&self.net(b)));
                    other
                }
                (None, Some(next)) => self.swapped(next),
                (None, None) => match passed.take().filter(|passed| self.is_more_than(passed, &best)) {
                    Some(passed) => self.swapped(passed),
                    None => return self.pruned(best),
                },
            };
        }
    }

    /// A set instead of `best`, and `best` with one effect more that is worth having.
    fn step_from(&mut self, best: &Scored) -> (Option<Scored>, Option<Scored>) {
        if self.is_full(best) {
            return (None, None);
        }
        self.look_farther(best);
        let next = self.with_another(best, best.score + self.limits.least_score);
        (self.instead(best), next)
    }

    /// The score of a set beyond what its members must add.
    pub(super) fn net(&self, scored: &Scored) -> f64 {
        scored.score - self.limits.least_score * scored.fitted.members.len() as f64
    }

    /// The score beyond which a set of so many effects is better than `best`.
    pub(super) fn enough_of(&self, effects: usize, best: &Scored) -> f64 {
        self.net(best) + self.limits.least_score * effects as f64
    }

    /// Whether `other` is better than `best`, and not just that with members that it has been tried with.
    fn is_more_than(&self, other: &Scored, best: &Scored) -> bool {
        let tried = set_of(&other.fitted.members).is_superset(&set_of(&best.fitted.members));
        !tried && self.net(other) > self.net(best)
    }

    /// Goes on from `best`, so that nothing is left out because of what it promised: other single effects first, if
    /// something is `left` that it does not explain, then more of them, then other pairs.
    pub(super) fn thoroughly(&mut self, mut best: Scored, left: bool) -> Scored {
        self.limits.thorough = if left { usize::MAX } else { 2 };
        self.look_farther(&best);
        if left && !best.fitted.members.is_empty() {
            best = self.with_another(&self.null.clone(), best.score).unwrap_or(best);
        }
        let best = self.enlarged(best);
        self.paired_otherwise(best)
    }

    pub(super) fn is_thorough(&self, base: &Scored) -> bool {
        base.fitted.members.len() < self.limits.thorough
    }

    fn is_full(&self, best: &Scored) -> bool {
        best.fitted.members.len() >= self.limits.most_effects
    }

    /// Looks far out beside `best`, once: beside nothing only if anything may be missing, beside a full set never. A promise
    /// that pays for itself says so however small it is: something else may do more.
    fn look_farther(&mut self, best: &Scored) {
        let worth = |promise: &Promise| {
            self.study.promised(promise) > self.limits.least_score
                || self.study.is_worth_fitting(promise, &best.fitted, &self.limits)
        };
        let asked = self.is_thorough(best)
            || !best.fitted.members.is_empty()
            || self.study.promises(&best.fitted, &[], &self.responses).iter().any(worth);
        if asked && !self.is_full(best) && self.looked.insert(set_of(&best.fitted.members)) {
            self.responses.extend(self.study.farther(&best.fitted, &self.responses));
        }
    }

    /// What was found, with all that was tried on the way: what may be a rival fitted as well as can be.
    pub(super) fn ended(mut self, best: Scored) -> Found {
        for k in 0..self.tried.len() {
            if !self.tried[k].exact && self.tried[k].rivals(&best, self.limits.rival_score) {
                self.settle(k);
            }
        }
        let Search { study, null, responses, tried, .. } = self;
        let looked_at = study.promises(&null.fitted, &[], &responses).into_iter().map(|promise| {
            let score = study.promised(&promise);
            (promise, score)
        });
        Found { best, tried, looked_at: looked_at.collect(), null }
    }

    /// Fits what was tried as number `k` as well as can be.
    pub(super) fn settle(&mut self, k: usize) {
        self.tried[k] = self.settled(&self.tried[k]);
    }

    /// The same set fitted as well as can be, or as it is where that cannot be.
    pub(super) fn settled(&self, rough: &Scored) -> Scored {
        self.study.settled(&rough.fitted).map_or_else(|| rough.clone(), |fitted| self.scored(fitted))
    }

    pub(super) fn scored(&self, fitted: Fitted) -> Scored {
        let fall = self.null.fitted.explained.deviance - fitted.explained.deviance;
        Scored { score: fall - self.study.penalty(&fitted.members), fitted, exact: true }
    }

    /// Fits `base` with each of the promising hypotheses besides: all roughly, then as well as can be those that may come
    /// near the best of them and near the score `enough`.
    pub(super) fn fitted_with(&mut self, base: &Scored, promises: &[Promise], enough: f64) -> Vec<Scored> {
        let Some(first) = promises.first() else { return Vec::new() };
        let (least, width) = if self.is_thorough(base) {
            (f64::NEG_INFINITY, usize::MAX)
        } else {
            (first.gain - (PROMISE_SHARE * first.gain).max(PROMISE_SLACK), WIDTH)
        };
        let kept: Vec<&Promise> = promises.iter().take(width).filter(|promise| promise.gain >= least).collect();
        let mut rough = self.study.roughly_with(base, &kept, &self.responses, enough);
        rough.sort_by(|a, b| b.score.total_cmp(&a.score));
        let mut top = rough.iter().map(|scored| scored.score).fold(base.score.max(enough), f64::max);
        let mut finished: Vec<Scored> = Vec::new();
        for scored in rough {
            if finished.len() == WIDTH || !self.may_lead(&scored, base, top) {
                self.tried.push(scored);
                continue;
            }
            // What cannot be fitted further stays as roughly as it is, so that nothing that promises much is lost.
            let scored = self.settled(&scored);
            top = top.max(scored.score);
            finished.push(scored);
        }
        self.tried.extend(finished.iter().cloned());
        finished
    }

    /// Whether a rough fit of `base` with one member more may come near the score `top` once it is fitted further.
    fn may_lead(&self, rough: &Scored, base: &Scored, top: f64) -> bool {
        let adds = rough.score - base.score;
        let added = rough.fitted.members.last().map(|member| &self.study.hypotheses[member.hypothesis]);
        let share = if added.is_some_and(Hypothesis::has_shape) { SHAPELESS_SHARE } else { SHORT_SHARE };
        let hopeless = adds < HOPELESS - self.limits.rival_score;
        !hopeless && rough.score + share * adds.max(0.0) + SHORT >= top - self.limits.rival_score
    }
}
