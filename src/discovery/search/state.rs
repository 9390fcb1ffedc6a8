//! State of a search: the sets fitted so far with their scores.

use std::collections::BTreeSet;

use super::screening::LinearPrediction;
use crate::discovery::fit::gauss_newton::{FitProblem, FittedSet};
use crate::discovery::fit::sensitivities::Sensitivity;
use crate::discovery::options::SearchLimits;

/// A set of effects that was fitted, with its score.
#[derive(Clone, Debug)]
pub(crate) struct ScoredSet {
    pub(crate) fitted: FittedSet,
    /// Fall of the deviance since the model as given, less what its parameters and their choice cost.
    pub(crate) score: f64,
    /// Whether it is fitted as well as can be.
    pub(crate) exact: bool,
}

impl ScoredSet {
    /// Whether it could be the answer instead of `best`: with no more effects, and less than `rival_score` behind.
    pub(crate) fn is_rival_of(&self, best: &ScoredSet, rival_score: f64) -> bool {
        self.fitted.members.len() <= best.fitted.members.len() && self.score > best.score - rival_score
    }
}

/// What the search ends with.
pub(crate) struct SearchOutcome {
    /// The best set; empty when nothing is missing.
    pub(crate) best: ScoredSet,
    /// The model as given.
    pub(crate) null: ScoredSet,
    /// All sets that were fitted.
    pub(crate) tried: Vec<ScoredSet>,
    /// What every candidate predictions at a first look, with the score that it would have.
    pub(crate) screened: Vec<(LinearPrediction, f64)>,
}

/// A search on its way.
pub(crate) struct Search<'s> {
    pub(crate) fit_problem: &'s FitProblem<'s>,
    pub(crate) limits: SearchLimits,
    pub(crate) null: ScoredSet,
    /// The tip's answers to the candidates.
    pub(crate) sensitivities: Vec<Sensitivity>,
    /// The sets beside which they were looked at far out.
    pub(crate) screened_sets: BTreeSet<BTreeSet<usize>>,
    pub(crate) tried: Vec<ScoredSet>,
}

impl<'s> Search<'s> {
    /// A search for the set of candidates that explains the samples best, one that pays for its parameters (extended
    /// Bayesian information criterion, Chen & Chen, Biometrika 95, 2008). None where the model cannot play the samples.
    pub(crate) fn new(
        fit_problem: &'s FitProblem<'s>,
        sensitivities: Vec<Sensitivity>,
        limits: &SearchLimits,
    ) -> Option<Search<'s>> {
        let null = ScoredSet { fitted: fit_problem.evaluate_null()?, score: 0.0, exact: true };
        Some(Search {
            fit_problem,
            limits: *limits,
            null,
            sensitivities,
            screened_sets: BTreeSet::new(),
            tried: Vec::new(),
        })
    }

    /// The score of a set beyond what its members must add.
    pub(crate) fn net_score(&self, scored: &ScoredSet) -> f64 {
        scored.score - self.limits.least_score * scored.fitted.members.len() as f64
    }

    /// The score beyond which a set of so many effects is better than `best`.
    pub(crate) fn score_to_beat(&self, effects: usize, best: &ScoredSet) -> f64 {
        self.net_score(best) + self.limits.least_score * effects as f64
    }

    pub(crate) fn is_exhaustive(&self, base: &ScoredSet) -> bool {
        base.fitted.members.len() < self.limits.exhaustive_below
    }

    pub(crate) fn is_full(&self, best: &ScoredSet) -> bool {
        best.fitted.members.len() >= self.limits.most_effects
    }

    /// What was found, with all that was tried on the way: what may be a rival fitted as well as can be.
    pub(crate) fn into_outcome(mut self, best: ScoredSet) -> SearchOutcome {
        for k in 0..self.tried.len() {
            if !self.tried[k].exact && self.tried[k].is_rival_of(&best, self.limits.rival_score) {
                self.fit_fully_in_place(k);
            }
        }
        let Search { fit_problem, null, sensitivities, tried, .. } = self;
        let screened = fit_problem.predictions(&null.fitted, &[], &sensitivities).into_iter().map(|prediction| {
            let score = fit_problem.predicted_score(&prediction);
            (prediction, score)
        });
        SearchOutcome { best, tried, screened: screened.collect(), null }
    }

    /// Fits what was tried as number `k` as well as can be.
    pub(crate) fn fit_fully_in_place(&mut self, k: usize) {
        self.tried[k] = self.fit_fully(&self.tried[k]);
    }

    /// The same set fitted as well as can be, or as it is where that cannot be.
    pub(crate) fn fit_fully(&self, rough: &ScoredSet) -> ScoredSet {
        self.fit_problem.fit_fully(&rough.fitted).map_or_else(|| rough.clone(), |fitted| self.score(fitted))
    }

    pub(crate) fn score(&self, fitted: FittedSet) -> ScoredSet {
        let fall = self.null.fitted.nuisance_fit.deviance - fitted.nuisance_fit.deviance;
        ScoredSet { score: fall - self.fit_problem.penalty(&fitted.members), fitted, exact: true }
    }
}
