//! Moves to sets of equal or smaller size: an effect taken first may stand for one that comes later.

use std::collections::BTreeSet;

use super::fit_additions::WIDTH;
use super::screening::LinearPrediction;
use super::state::{ScoredSet, Search};
use crate::discovery::fit::candidate::candidate_set;

impl Search<'_> {
    /// A better set than `best` from the best superset without one of its old members (floating search; Pudil,
    /// Novovičová & Kittler, Pattern Recognition Letters 15, 1994).
    pub(crate) fn replacement(&mut self, best: &ScoredSet) -> Option<ScoredSet> {
        let members = candidate_set(&best.fitted.members);
        let larger = self.supersets(best).filter(|larger| larger.score > best.score);
        let larger = larger.max_by(|a, b| a.score.total_cmp(&b.score)).cloned()?;
        let old = |&out: &usize| members.contains(&larger.fitted.members[out].candidate);
        let fewer: Vec<ScoredSet> =
            (0..=members.len()).filter(old).filter_map(|out| self.remove(&larger, out)).collect();
        fewer.into_iter().filter(|fewer| fewer.score > best.score).max_by(|a, b| a.score.total_cmp(&b.score))
    }

    /// Swaps members as long as that improves the score.
    pub(crate) fn swap_members(&mut self, mut best: ScoredSet) -> ScoredSet {
        if best.fitted.members.len() < 2 {
            return best;
        }
        loop {
            let mut better: Option<ScoredSet> = None;
            for out in 0..best.fitted.members.len() {
                let enough = better.as_ref().map_or(best.score, |better| better.score);
                better = self.swap_member(&best, out, enough).or(better);
            }
            match better {
                Some(next) => best = next,
                None => return best,
            }
        }
    }

    /// The set with member `out` replaced, if its score exceeds `enough`. Tries first with the other members
    /// unchanged; in a pair also with the other refitted.
    fn swap_member(&mut self, best: &ScoredSet, out: usize, enough: f64) -> Option<ScoredSet> {
        let kept = self.fit_problem.evaluate_without(&best.fitted, out).map(|rest| self.score(rest));
        let gone = best.fitted.members[out].candidate;
        let width = WIDTH / best.fitted.members.len();
        if let Some(better) = kept.and_then(|rest| self.best_addition_except(gone, &rest, enough, width)) {
            return Some(better);
        }
        let anew = if best.fitted.members.len() == 2 { self.remove(best, out) } else { None };
        anew.and_then(|rest| self.best_addition_except(gone, &rest, enough, width))
    }

    /// The best of `rest` with one of `width` promising members other than `gone`, if its score exceeds `enough`.
    fn best_addition_except(&mut self, gone: usize, rest: &ScoredSet, enough: f64, width: usize) -> Option<ScoredSet> {
        let mut predictions = self.fit_problem.predictions(&rest.fitted, &[gone], &self.sensitivities);
        predictions.retain(|prediction| !self.is_fitted(rest, prediction));
        predictions.truncate(width);
        let fits = self.fit_additions(rest, &predictions, enough);
        fits.into_iter().filter(|fit| fit.score > enough).max_by(|a, b| a.score.total_cmp(&b.score))
    }

    /// Whether the set extended by the prediction was fully fitted.
    fn is_fitted(&self, base: &ScoredSet, prediction: &LinearPrediction) -> bool {
        let all = extended_set(base, prediction);
        self.tried.iter().any(|scored| scored.exact && candidate_set(&scored.fitted.members) == all)
    }

    /// Whether the set extended by the prediction was fitted, at least roughly from `base`.
    pub(crate) fn is_tried(&self, base: &ScoredSet, prediction: &LinearPrediction) -> bool {
        let (all, added) = (extended_set(base, prediction), prediction.member.candidate);
        let from_here = |scored: &ScoredSet| scored.fitted.members.last().is_some_and(|last| last.candidate == added);
        self.tried
            .iter()
            .any(|scored| (scored.exact || from_here(scored)) && candidate_set(&scored.fitted.members) == all)
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
        let wanted = candidate_set(&rest);
        let known = self.tried.iter().filter(|scored| scored.exact && candidate_set(&scored.fitted.members) == wanted);
        if let Some(known) = known.max_by(|a, b| a.score.total_cmp(&b.score)) {
            return Some(known.clone());
        }
        let fewer = self.score(self.fit_problem.refit(rest, self.fit_problem.jacobian_without(&best.fitted, out))?);
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
