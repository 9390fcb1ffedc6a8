//! State of a search: the sets fitted so far with their scores.

use std::collections::BTreeSet;

use super::screening::LinearPrediction;
use crate::discovery::fit::candidate::candidate_set;
use crate::discovery::fit::gauss_newton::{FitProblem, FittedSet};
use crate::discovery::fit::sensitivities::Sensitivity;
use crate::discovery::options::SearchLimits;

/// A fitted candidate set with its score.
#[derive(Clone, Debug)]
pub(crate) struct ScoredSet {
    pub(crate) fitted: FittedSet,
    /// Decrease of the deviance relative to the given model, minus the penalty.
    pub(crate) score: f64,
    /// Whether it is fully fitted.
    pub(crate) exact: bool,
}

impl ScoredSet {
    /// Whether it is a rival of `best`: no more effects, and a score less than `rival_score` below.
    pub(crate) fn is_rival_of(&self, best: &ScoredSet, rival_score: f64) -> bool {
        self.fitted.members.len() <= best.fitted.members.len()
            && self.score > best.score - rival_score
    }
}

/// Evidence on the best set from its amplitude in single trials.
pub(crate) struct TrialEvidence {
    /// Sets that fit unseen trials as well.
    pub(crate) equals: Vec<BTreeSet<usize>>,
    /// Half of the 95 % interval of the mean amplitude, over its mean.
    pub(crate) half_width: f64,
}

/// Result of a search.
pub(crate) struct SearchOutcome {
    /// The best set; empty if nothing is missing.
    pub(crate) best: ScoredSet,
    /// The given model.
    pub(crate) null: ScoredSet,
    /// All fitted sets.
    pub(crate) tried: Vec<ScoredSet>,
    /// Where trials decide instead of scores: how.
    pub(crate) by_trials: Option<TrialEvidence>,
    /// Linear prediction of every candidate with its predicted score.
    pub(crate) screened: Vec<(LinearPrediction, f64)>,
}

impl SearchOutcome {
    /// Whether a set is a rival of the best one.
    pub(crate) fn is_rival(&self, scored: &ScoredSet, rival_score: f64) -> bool {
        match &self.by_trials {
            Some(evidence) => evidence.equals.contains(&candidate_set(&scored.fitted.members)),
            None => scored.is_rival_of(&self.best, rival_score),
        }
    }
}

/// State of a search.
pub(crate) struct Search<'s> {
    pub(crate) fit_problem: &'s FitProblem<'s>,
    pub(crate) limits: SearchLimits,
    pub(crate) null: ScoredSet,
    /// Sensitivities to the candidates.
    pub(crate) sensitivities: Vec<Sensitivity>,
    /// Sets for which large-amplitude sensitivities were computed.
    pub(crate) screened_sets: BTreeSet<BTreeSet<usize>>,
    pub(crate) tried: Vec<ScoredSet>,
}

impl<'s> Search<'s> {
    /// A search for the candidate set with the best penalised likelihood (extended Bayesian
    /// information criterion, Chen & Chen, Biometrika 95, 2008). None if the model cannot be
    /// simulated.
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

    /// The score minus the required gain of its members.
    pub(crate) fn net_score(&self, scored: &ScoredSet) -> f64 {
        scored.score - self.limits.least_score * scored.fitted.members.len() as f64
    }

    /// The score that a set of this many effects must exceed to be better than `best`.
    pub(crate) fn score_to_beat(&self, effects: usize, best: &ScoredSet) -> f64 {
        self.net_score(best) + self.limits.least_score * effects as f64
    }

    pub(crate) fn is_exhaustive(&self, base: &ScoredSet) -> bool {
        base.fitted.members.len() < self.limits.exhaustive_below
    }

    pub(crate) fn is_full(&self, best: &ScoredSet) -> bool {
        best.fitted.members.len() >= self.limits.most_effects
    }

    /// The outcome, with possible rivals fully fitted.
    pub(crate) fn into_outcome(mut self, best: ScoredSet) -> SearchOutcome {
        for k in 0..self.tried.len() {
            // A rough fit is a lower bound; a rival must be fitted as well as the answer.
            if !self.tried[k].exact && self.tried[k].is_rival_of(&best, self.limits.rival_score) {
                self.tried[k] = self.fit_fully(&self.tried[k]);
            }
        }
        let Search { fit_problem, null, sensitivities, tried, .. } = self;
        let screened = fit_problem.predictions(&null.fitted, &[], &sensitivities).into_iter().map(
            |prediction| {
                let score = fit_problem.predicted_score(&prediction);
                (prediction, score)
            },
        );
        SearchOutcome { best, tried, by_trials: None, screened: screened.collect(), null }
    }

    /// The same set fully fitted, or unchanged if that fails.
    pub(crate) fn fit_fully(&self, rough: &ScoredSet) -> ScoredSet {
        self.fit_problem
            .fit_fully(&rough.fitted)
            .map_or_else(|| rough.clone(), |fitted| self.score(fitted))
    }

    pub(crate) fn score(&self, fitted: FittedSet) -> ScoredSet {
        let decrease = self.null.fitted.nuisance_fit.deviance - fitted.nuisance_fit.deviance;
        ScoredSet {
            score: decrease - self.fit_problem.penalty(&fitted.members),
            fitted,
            exact: true,
        }
    }
}
