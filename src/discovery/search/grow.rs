//! Stepwise search: grow the set while an effect is worth adding, swap members, then widen the search to pairs.

use super::screening::{HOPELESS, LinearPrediction};
use super::state::{ScoredSet, Search};
use crate::discovery::fit::candidate::candidate_set;
use crate::discovery::fit::gauss_newton::{FitProblem, FittedSet};
use crate::discovery::options::SearchLimits;

/// A first look may be wrong by this share of the size.
const NEARLY: f64 = 0.7;

impl FitProblem<'_> {
    /// Whether what a first look predictions beside `base` may turn out to be worth having.
    pub(crate) fn is_worth_fitting(
        &self,
        prediction: &LinearPrediction,
        base: &FittedSet,
        limits: &SearchLimits,
    ) -> bool {
        let least_m = NEARLY * limits.least_m(base.nuisance_fit.noise.rms_m());
        self.predicted_score(prediction) > limits.least_score + HOPELESS && prediction.size_m > least_m
    }
}

impl Search<'_> {
    /// The best set as far as predictions lead.
    pub(crate) fn greedy(&mut self) -> ScoredSet {
        self.grow(self.null.clone())
    }

    /// `best` with more effects, as long as each is worth having.
    pub(crate) fn grow(&mut self, mut best: ScoredSet) -> ScoredSet {
        // The best that was worth having where the search went elsewhere.
        let mut passed: Option<ScoredSet> = None;
        loop {
            best = match self.propose_steps(&best) {
                (Some(other), next) => {
                    passed =
                        passed.into_iter().chain(next).max_by(|a, b| self.net_score(a).total_cmp(&self.net_score(b)));
                    other
                }
                (None, Some(next)) => self.swap_members(next),
                (None, None) => match passed.take().filter(|passed| self.is_unrelated_and_better(passed, &best)) {
                    Some(passed) => self.swap_members(passed),
                    None => return self.prune(best),
                },
            };
        }
    }

    /// A set instead of `best`, and `best` with one effect more that is worth having.
    fn propose_steps(&mut self, best: &ScoredSet) -> (Option<ScoredSet>, Option<ScoredSet>) {
        if self.is_full(best) {
            return (None, None);
        }
        self.screen_large_amplitudes(best);
        let next = self.add_one(best, best.score + self.limits.least_score);
        (self.replacement(best), next)
    }

    /// Whether `other` is better than `best`, and not just that with members that it has been tried with.
    fn is_unrelated_and_better(&self, other: &ScoredSet, best: &ScoredSet) -> bool {
        let tried = candidate_set(&other.fitted.members).is_superset(&candidate_set(&best.fitted.members));
        !tried && self.net_score(other) > self.net_score(best)
    }

    /// Goes on from `best`, so that nothing is left out because of what it promised: other single effects first, if
    /// something is `left` that it does not explain, then more of them, then other pairs.
    pub(crate) fn widen(&mut self, mut best: ScoredSet, left: bool) -> ScoredSet {
        self.limits.exhaustive_below = if left { usize::MAX } else { 2 };
        self.screen_large_amplitudes(&best);
        if left && !best.fitted.members.is_empty() {
            best = self.add_one(&self.null.clone(), best.score).unwrap_or(best);
        }
        let best = self.grow(best);
        self.try_pairs(best)
    }

    /// Looks far out beside `best`, once: beside nothing only if anything may be missing, beside a full set never. A prediction
    /// that pays for itself says so however small it is: something else may do more.
    fn screen_large_amplitudes(&mut self, best: &ScoredSet) {
        let worth = |prediction: &LinearPrediction| {
            self.fit_problem.predicted_score(prediction) > self.limits.least_score
                || self.fit_problem.is_worth_fitting(prediction, &best.fitted, &self.limits)
        };
        let asked = self.is_exhaustive(best)
            || !best.fitted.members.is_empty()
            || self.fit_problem.predictions(&best.fitted, &[], &self.sensitivities).iter().any(worth);
        if asked && !self.is_full(best) && self.screened_sets.insert(candidate_set(&best.fitted.members)) {
            self.sensitivities
                .extend(self.fit_problem.large_amplitude_sensitivities(&best.fitted, &self.sensitivities));
        }
    }
}
