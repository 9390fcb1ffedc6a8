//! Stepwise search: grow the set while an effect is worth adding, swap members, then widen the search to pairs.

use super::screening::{HOPELESS, LinearPrediction};
use super::state::{ScoredSet, Search};
use crate::discovery::fit::candidate::candidate_set;
use crate::discovery::fit::gauss_newton::{FitProblem, FittedSet};
use crate::discovery::options::SearchLimits;

/// Relative error of a predicted size.
const NEARLY: f64 = 0.7;

impl FitProblem<'_> {
    /// Whether a prediction relative to `base` justifies a fit.
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
    /// Grows `best` as long as an added effect is worth adding.
    pub(crate) fn grow(&mut self, mut best: ScoredSet) -> ScoredSet {
        // The best set of the other branches.
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

    /// A replacement of `best`, and `best` with one effect added.
    fn propose_steps(&mut self, best: &ScoredSet) -> (Option<ScoredSet>, Option<ScoredSet>) {
        if self.is_full(best) {
            return (None, None);
        }
        self.screen_large_amplitudes(best);
        let next = self.add_one(best, best.score + self.limits.least_score);
        (self.replacement(best), next)
    }

    /// Whether `other` is better than `best` and no superset of it.
    fn is_unrelated_and_better(&self, other: &ScoredSet, best: &ScoredSet) -> bool {
        let tried = candidate_set(&other.fitted.members).is_superset(&candidate_set(&best.fitted.members));
        !tried && self.net_score(other) > self.net_score(best)
    }

    /// Widens the search so that no candidate is excluded by its prediction: other single effects if something is
    /// `left`, then larger sets, then pairs.
    pub(crate) fn widen(&mut self, mut best: ScoredSet, left: bool) -> ScoredSet {
        self.limits.exhaustive_below = if left { usize::MAX } else { 2 };
        self.screen_large_amplitudes(&best);
        if left && !best.fitted.members.is_empty() {
            best = self.add_one(&self.null.clone(), best.score).unwrap_or(best);
        }
        let best = self.grow(best);
        self.try_pairs(best)
    }

    /// Computes large-amplitude sensitivities relative to `best`, once a set: for the empty set only if an effect may
    /// be missing, for a full set never. A prediction that justifies its penalty suffices, however small.
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
