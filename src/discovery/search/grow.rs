//! Stepwise search: grow the set while an effect is worth adding, swap members, then widen the
//! search to pairs.

use super::screening::{LinearPrediction, MIN_PREDICTED_SCORE};
use super::state::{ScoredSet, Search};
use crate::discovery::fit::candidate::candidate_set;
use crate::discovery::fit::gauss_newton::{FitProblem, FittedSet};
use crate::discovery::options::SearchLimits;

/// A predicted size may be this much too small, as a share of the required one.
const MIN_SIZE_SHARE: f64 = 0.7;

impl FitProblem<'_> {
    /// Whether a prediction relative to `base` justifies a fit.
    pub(crate) fn is_worth_fitting(
        &self,
        prediction: &LinearPrediction,
        base: &FittedSet,
        limits: &SearchLimits,
    ) -> bool {
        let min_size_m = MIN_SIZE_SHARE * limits.least_m(base.nuisance_fit.noise.rms_m());
        self.predicted_score(prediction) > limits.least_score + MIN_PREDICTED_SCORE
            && prediction.size_m > min_size_m
    }
}

impl Search<'_> {
    /// Grows `best` as long as an added effect is worth adding.
    pub(crate) fn grow(&mut self, mut best: ScoredSet) -> ScoredSet {
        // The best set that was worth having where the search went elsewhere.
        let mut other_branch: Option<ScoredSet> = None;
        loop {
            best = match self.propose_steps(&best) {
                // A replacement comes before growth: what was taken first may stand for two others.
                (Some(other), next) => {
                    let reached = other_branch.into_iter().chain(next);
                    other_branch =
                        reached.max_by(|a, b| self.net_score(a).total_cmp(&self.net_score(b)));
                    other
                }
                (None, Some(next)) => self.swap_members(next),
                (None, None) => match other_branch
                    .take()
                    .filter(|other| self.is_unrelated_and_better(other, &best))
                {
                    Some(other) => self.swap_members(other),
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
        // Responses beside this set decide what is worth adding to it.
        self.screen_large_amplitudes(best);
        let next = self.add_one(best, best.score + self.limits.least_score);
        (self.replacement(best), next)
    }

    /// Whether `other` is better than `best` and no superset of it.
    fn is_unrelated_and_better(&self, other: &ScoredSet, best: &ScoredSet) -> bool {
        let is_superset =
            candidate_set(&other.fitted.members).is_superset(&candidate_set(&best.fitted.members));
        !is_superset && self.net_score(other) > self.net_score(best)
    }

    /// Widens the search so that no candidate is excluded by its prediction: other single effects
    /// if the best set `is_rejected`, then larger sets, then pairs.
    pub(crate) fn widen(&mut self, mut best: ScoredSet, is_rejected: bool) -> ScoredSet {
        // After a failed test no prediction may exclude a candidate, whatever the size of the set.
        self.limits.exhaustive_below = if is_rejected { usize::MAX } else { 2 };
        self.screen_large_amplitudes(&best);
        if is_rejected && !best.fitted.members.is_empty() {
            // A first look is linear, and a delay does not look like one.
            best = self.add_one(&self.null.clone(), best.score).unwrap_or(best);
        }
        let best = self.grow(best);
        self.try_pairs(best)
    }

    /// Computes large-amplitude sensitivities relative to `best`, once a set: for the empty set
    /// only if an effect may be missing, for a full set never. A prediction that justifies its
    /// penalty suffices, however small.
    fn screen_large_amplitudes(&mut self, best: &ScoredSet) {
        let is_worth = |prediction: &LinearPrediction| {
            self.fit_problem.predicted_score(prediction) > self.limits.least_score
                || self.fit_problem.is_worth_fitting(prediction, &best.fitted, &self.limits)
        };
        let is_due = self.is_exhaustive(best)
            || !best.fitted.members.is_empty()
            || self
                .fit_problem
                .predictions(&best.fitted, &[], &self.sensitivities)
                .iter()
                .any(is_worth);
        if is_due
            && !self.is_full(best)
            && self.screened_sets.insert(candidate_set(&best.fitted.members))
        {
            self.sensitivities.extend(
                self.fit_problem.large_amplitude_sensitivities(&best.fitted, &self.sensitivities),
            );
        }
    }
}
