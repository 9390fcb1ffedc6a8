//! Pairs that no single effect leads to: a single effect may stand for two others, neither of which
//! helps much beside it.

use std::collections::BTreeSet;

use super::screening::LinearPrediction;
use super::state::{ScoredSet, Search};
use super::swap::extended_set;
use crate::discovery::fit::candidate::candidate_set;

/// Maximum number of pairs without a member of the current best set.
const MAX_OTHER_PAIRS: usize = 16;

/// A fitted single effect with a predicted second one.
struct PredictedPair {
    score: f64,
    /// Index of the single effect.
    single: usize,
    prediction: LinearPrediction,
}

impl Search<'_> {
    /// `best`, or the result from the best pair that was not tried, if that is better.
    pub(crate) fn try_pairs(&mut self, best: ScoredSet) -> ScoredSet {
        if self.limits.most_effects < 2 {
            return best;
        }
        // A pair must pay for its size against the best set so far.
        let min_score = self.score_to_beat(2, &best);
        let mut pairs: Vec<ScoredSet> = Vec::new();
        for (single, predictions) in self.promising_pairs(&candidate_set(&best.fitted.members)) {
            pairs.extend(self.fit_additions(&single, &predictions, min_score));
        }
        pairs.retain(|pair| pair.score > min_score);
        pairs.sort_by(|a, b| b.score.total_cmp(&a.score));
        match pairs.into_iter().find(|pair| self.is_each_worth_adding(pair)) {
            Some(pair) => {
                let pair = self.swap_members(pair);
                self.grow(pair)
            }
            None => best,
        }
    }

    /// Whether each member is worth adding to the other.
    fn is_each_worth_adding(&mut self, pair: &ScoredSet) -> bool {
        (0..2)
            .all(|out| self.remove(pair, out).is_some_and(|rest| self.is_worth_adding(&rest, pair)))
    }

    /// Predictions beside fitted single effects for pairs that were not fitted: all pairs with one
    /// of `members`, and the most promising others.
    fn promising_pairs(
        &self,
        members: &BTreeSet<usize>,
    ) -> Vec<(ScoredSet, Vec<LinearPrediction>)> {
        let singles = self.singles();
        let mut pairs: Vec<PredictedPair> = Vec::new();
        for (number, single) in singles.iter().enumerate() {
            let predictions =
                self.fit_problem.predictions(&single.fitted, &[], &self.sensitivities).into_iter();
            let new = predictions.filter(|prediction| !self.is_tried(single, prediction));
            pairs.extend(new.map(|prediction| {
                // The prediction beside the single effect, whose residual differs from that of the
                // model.
                let score = single.score + self.fit_problem.predicted_score(&prediction);
                PredictedPair { score, single: number, prediction }
            }));
        }
        pairs.sort_by(|a, b| b.score.total_cmp(&a.score));
        let (mut listed, mut others) = (BTreeSet::new(), 0..MAX_OTHER_PAIRS);
        pairs.retain(|pair| {
            let set = extended_set(singles[pair.single], &pair.prediction);
            let has_member = !set.is_disjoint(members);
            // Either order of a pair is the same set; the first one promises more.
            listed.insert(set) && (has_member || others.next().is_some())
        });
        let beside = |number: usize| -> Vec<LinearPrediction> {
            pairs
                .iter()
                .filter(|pair| pair.single == number)
                .map(|pair| pair.prediction.clone())
                .collect()
        };
        let with_predictions =
            singles.iter().enumerate().map(|(number, &single)| (single, beside(number)));
        let predicted = with_predictions.filter(|(_, predictions)| !predictions.is_empty());
        predicted.map(|(single, predictions)| (single.clone(), predictions)).collect()
    }

    /// Fully fitted single effects, best first.
    fn singles(&self) -> Vec<&ScoredSet> {
        let mut singles: Vec<&ScoredSet> =
            self.tried.iter().filter(|scored| scored.fitted.members.len() == 1).collect();
        singles.sort_by(|a, b| b.score.total_cmp(&a.score));
        let mut listed = BTreeSet::new();
        singles.retain(|single| listed.insert(candidate_set(&single.fitted.members)));
        singles
    }
}
