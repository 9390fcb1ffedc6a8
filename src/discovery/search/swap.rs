//! Moves to sets of equal or smaller size: an effect taken first may stand for one that comes
//! later.

use std::collections::BTreeSet;

use super::fit_additions::MAX_FITS;
use super::screening::LinearPrediction;
use super::state::{ScoredSet, Search};
use crate::discovery::fit::candidate::candidate_set;

impl Search<'_> {
    /// A better set than `best` from the best superset without one of its old members (floating
    /// search; Pudil, Novovičová & Kittler, Pattern Recognition Letters 15, 1994).
    pub(crate) fn replacement(&mut self, best: &ScoredSet) -> Option<ScoredSet> {
        let members = candidate_set(&best.fitted.members);
        let larger = self.supersets(best).filter(|larger| larger.score > best.score);
        let larger = larger.max_by(|a, b| a.score.total_cmp(&b.score)).cloned()?;
        let old = |&out: &usize| members.contains(&larger.fitted.members[out].candidate);
        // Only the members that it began with: the new one is what made it better.
        let fewer: Vec<ScoredSet> =
            (0..=members.len()).filter(old).filter_map(|out| self.remove(&larger, out)).collect();
        fewer
            .into_iter()
            .filter(|fewer| fewer.score > best.score)
            .max_by(|a, b| a.score.total_cmp(&b.score))
    }

    /// Swaps members as long as that improves the score.
    pub(crate) fn swap_members(&mut self, mut best: ScoredSet) -> ScoredSet {
        if best.fitted.members.len() < 2 {
            return best;
        }
        loop {
            let mut better: Option<ScoredSet> = None;
            for out in 0..best.fitted.members.len() {
                let min_score = better.as_ref().map_or(best.score, |better| better.score);
                better = self.swap_member(&best, out, min_score).or(better);
            }
            match better {
                Some(next) => best = next,
                None => return best,
            }
        }
    }

    /// The set with member `out` replaced, if its score exceeds `min_score`. Tries first with the
    /// other members unchanged; in a pair also with the other refitted.
    fn swap_member(&mut self, best: &ScoredSet, out: usize, min_score: f64) -> Option<ScoredSet> {
        let kept =
            self.fit_problem.evaluate_without(&best.fitted, out).map(|rest| self.score(rest));
        let removed = best.fitted.members[out].candidate;
        // As many fits for every size of set.
        let width = MAX_FITS / best.fitted.members.len();
        if let Some(better) =
            kept.and_then(|rest| self.best_addition_except(removed, &rest, min_score, width))
        {
            return Some(better);
        }
        // In a pair the other member may have stood for both, so it is refitted alone.
        let refitted = if best.fitted.members.len() == 2 { self.remove(best, out) } else { None };
        refitted.and_then(|rest| self.best_addition_except(removed, &rest, min_score, width))
    }

    /// The best of `rest` with one of `width` promising members other than `removed`, if its score
    /// exceeds `min_score`.
    fn best_addition_except(
        &mut self,
        removed: usize,
        rest: &ScoredSet,
        min_score: f64,
        width: usize,
    ) -> Option<ScoredSet> {
        let mut predictions =
            self.fit_problem.predictions(&rest.fitted, &[removed], &self.sensitivities);
        predictions.retain(|prediction| !self.is_fitted(rest, prediction));
        predictions.truncate(width);
        let fits = self.fit_additions(rest, &predictions, min_score);
        fits.into_iter()
            .filter(|fit| fit.score > min_score)
            .max_by(|a, b| a.score.total_cmp(&b.score))
    }

    /// Whether the set extended by the prediction was fully fitted.
    fn is_fitted(&self, base: &ScoredSet, prediction: &LinearPrediction) -> bool {
        let all = extended_set(base, prediction);
        self.tried.iter().any(|scored| scored.exact && candidate_set(&scored.fitted.members) == all)
    }

    /// Whether the set extended by the prediction was fitted, at least roughly from `base`.
    pub(crate) fn is_tried(&self, base: &ScoredSet, prediction: &LinearPrediction) -> bool {
        let (all, added) = (extended_set(base, prediction), prediction.member.candidate);
        let from_here = |scored: &ScoredSet| {
            scored.fitted.members.last().is_some_and(|last| last.candidate == added)
        };
        self.tried.iter().any(|scored| {
            (scored.exact || from_here(scored)) && candidate_set(&scored.fitted.members) == all
        })
    }

    /// Removes members that do not justify their penalty.
    pub(crate) fn prune(&mut self, mut best: ScoredSet) -> ScoredSet {
        let mut k = 0;
        while best.fitted.members.len() > 1 && k < best.fitted.members.len() {
            match self.remove(&best, k) {
                Some(fewer) if fewer.score + self.limits.least_score > best.score => best = fewer,
                _ => k += 1,
            }
        }
        best
    }

    /// The set without member `out`, refitted unless it was before.
    pub(crate) fn remove(&mut self, best: &ScoredSet, out: usize) -> Option<ScoredSet> {
        let mut rest = best.fitted.members.clone();
        rest.remove(out);
        let candidates = candidate_set(&rest);
        let fitted_before = self
            .tried
            .iter()
            .filter(|scored| scored.exact && candidate_set(&scored.fitted.members) == candidates);
        if let Some(fitted_before) = fitted_before.max_by(|a, b| a.score.total_cmp(&b.score)) {
            return Some(fitted_before.clone());
        }
        let fewer = self.score(
            self.fit_problem.refit(rest, self.fit_problem.jacobian_without(&best.fitted, out))?,
        );
        self.tried.push(fewer.clone());
        Some(fewer)
    }
}

/// Candidates of `base` and of the prediction.
pub(crate) fn extended_set(base: &ScoredSet, prediction: &LinearPrediction) -> BTreeSet<usize> {
    let mut all = candidate_set(&base.fitted.members);
    all.insert(prediction.member.candidate);
    all
}
