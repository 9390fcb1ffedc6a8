//! Forward step: add the best member if it is worth adding.

use std::collections::BTreeSet;

use super::state::{ScoredSet, Search};
use crate::discovery::fit::candidate::candidate_set;
use crate::discovery::fit::gauss_newton::FittedSet;
use crate::discovery::recording::samples::rms_m;

impl Search<'_> {
    /// `base` with the best member added, if it is worth adding and the score is at least
    /// `min_score`.
    pub(crate) fn add_one(&mut self, base: &ScoredSet, min_score: f64) -> Option<ScoredSet> {
        let limits = self.limits;
        let mut predictions = self.fit_problem.predictions(&base.fitted, &[], &self.sensitivities);
        // Sets that were fitted before are not fitted again.
        predictions.retain(|prediction| !self.is_tried(base, prediction));
        if !self.is_exhaustive(base) {
            predictions.retain(|prediction| {
                self.fit_problem.is_worth_fitting(prediction, &base.fitted, &limits)
            });
        }
        // Sets that were fitted on another way count as well.
        let rough =
            self.fit_additions(base, &predictions, min_score).into_iter().filter(|fit| !fit.exact);
        let mut fits: Vec<ScoredSet> = rough.chain(self.supersets(base).cloned()).collect();
        fits.retain(|next| next.score >= min_score);
        fits.sort_by(|a, b| b.score.total_cmp(&a.score));
        fits.into_iter()
            .find(|next| self.is_worth_adding(base, next))
            .or_else(|| self.best_rough_superset(base, min_score))
    }

    /// Fully fitted sets of `base` and one more member.
    pub(crate) fn supersets(&self, base: &ScoredSet) -> impl Iterator<Item = &ScoredSet> {
        let members = candidate_set(&base.fitted.members);
        self.tried.iter().filter(move |scored| scored.exact && is_larger(scored, &members))
    }

    /// The best of the roughly fitted supersets, after a full fit.
    fn best_rough_superset(&mut self, base: &ScoredSet, min_score: f64) -> Option<ScoredSet> {
        let members = candidate_set(&base.fitted.members);
        let mut rough: Vec<usize> = (0..self.tried.len()).collect();
        rough.retain(|&k| {
            !self.tried[k].exact
                && self.tried[k].score >= min_score
                && is_larger(&self.tried[k], &members)
        });
        rough.sort_by(|&a, &b| self.tried[b].score.total_cmp(&self.tried[a].score));
        rough.into_iter().find_map(|k| {
            self.tried[k] = self.fit_fully(&self.tried[k]);
            let fitted = self.tried[k].clone();
            (fitted.exact && fitted.score >= min_score && self.is_worth_adding(base, &fitted))
                .then_some(fitted)
        })
    }

    /// Whether the member that `next` adds to `base` is worth adding: it moves the tip far
    /// min_score, farther than the law errors of the others, and explains more than the model
    /// leaves on this robot anyway.
    pub(crate) fn is_worth_adding(&self, base: &ScoredSet, next: &ScoredSet) -> bool {
        // Squares subtract: the effect must explain more than the model leaves on this robot
        // anyway.
        let [before_m, after_m] =
            [base, next].map(|set| rms_m(&set.fitted.nuisance_fit.residual_m));
        if before_m.powi(2) - after_m.powi(2) < self.limits.least_gain_m.powi(2) {
            return false;
        }
        // No law is right to the last tenth: the effect must do more than the law error of those
        // before it.
        let law_error_m = self.limits.least_share * apart_m(&base.fitted, &self.null.fitted);
        if apart_m(&next.fitted, &base.fitted) < law_error_m {
            return false;
        }
        // The size of an effect is how far it moves the tip by itself, beside the others as they
        // are.
        let added =
            next.fitted.members.iter().position(|member| !base.fitted.has(member.candidate));
        let without_added =
            added.and_then(|added| self.fit_problem.evaluate_without(&next.fitted, added));
        let min_m = self.limits.least_m(next.fitted.nuisance_fit.noise.rms_m());
        without_added.is_some_and(|without_added| apart_m(&next.fitted, &without_added) >= min_m)
    }
}

/// Rms distance between the simulated tips of two fits, metres.
fn apart_m(there: &FittedSet, here: &FittedSet) -> f64 {
    let moved: Vec<f64> =
        there.simulated_m.iter().zip(&here.simulated_m).map(|(there, here)| there - here).collect();
    rms_m(&moved)
}

/// Whether a set is the `members` and one more.
fn is_larger(scored: &ScoredSet, members: &BTreeSet<usize>) -> bool {
    let candidates = candidate_set(&scored.fitted.members);
    candidates.len() == members.len() + 1 && candidates.is_superset(members)
}
