//! Pairs that no single effect leads to: a single effect may stand for two others, neither of which helps much beside
//! it.

use std::collections::BTreeSet;

use super::screening::LinearPrediction;
use super::state::{ScoredSet, Search};
use super::swap::extended_set;
use crate::discovery::fit::candidate::candidate_set;

/// Maximum number of pairs without a member of the current best set.
const PAIRS: usize = 16;

impl Search<'_> {
    /// `best`, or the result from the best pair that was not tried, if that is better.
    pub(crate) fn try_pairs(&mut self, best: ScoredSet) -> ScoredSet {
        if self.limits.most_effects < 2 {
            return best;
        }
        let enough = self.score_to_beat(2, &best);
        let mut pairs: Vec<ScoredSet> = Vec::new();
        for (single, predictions) in self.promising_pairs(&candidate_set(&best.fitted.members)) {
            pairs.extend(self.fit_additions(&single, &predictions, enough));
        }
        pairs.retain(|pair| pair.score > enough);
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
        (0..2).all(|out| self.remove(pair, out).is_some_and(|rest| self.is_worth_adding(&rest, pair)))
    }

    /// Predictions beside fitted single effects for pairs that were not fitted: all pairs with one of `members`, and
    /// the most promising others.
    fn promising_pairs(&self, members: &BTreeSet<usize>) -> Vec<(ScoredSet, Vec<LinearPrediction>)> {
        let singles = self.singles();
        let mut pairs: Vec<(f64, usize, LinearPrediction)> = Vec::new();
        for (number, single) in singles.iter().enumerate() {
            let predictions = self.fit_problem.predictions(&single.fitted, &[], &self.sensitivities).into_iter();
            let new = predictions.filter(|prediction| !self.is_tried(single, prediction));
            pairs.extend(
                new.map(|prediction| {
                    (single.score + self.fit_problem.predicted_score(&prediction), number, prediction)
                }),
            );
        }
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (mut seen, mut others) = (BTreeSet::new(), 0..PAIRS);
        pairs.retain(|(_, single, prediction)| {
            let pair = extended_set(singles[*single], prediction);
            let beside_member = !pair.is_disjoint(members);
            seen.insert(pair) && (beside_member || others.next().is_some())
        });
        let beside = |number: usize| -> Vec<LinearPrediction> {
            pairs.iter().filter(|pair| pair.1 == number).map(|pair| pair.2.clone()).collect()
        };
        let with_promises = singles.iter().enumerate().map(|(number, &single)| (single, beside(number)));
        let kept = with_promises.filter(|(_, predictions)| !predictions.is_empty());
        kept.map(|(single, predictions)| (single.clone(), predictions)).collect()
    }

    /// Fully fitted single effects, best first.
    fn singles(&self) -> Vec<&ScoredSet> {
        let mut singles: Vec<&ScoredSet> =
            self.tried.iter().filter(|scored| scored.fitted.members.len() == 1).collect();
        singles.sort_by(|a, b| b.score.total_cmp(&a.score));
        let mut seen = BTreeSet::new();
        singles.retain(|single| seen.insert(candidate_set(&single.fitted.members)));
        singles
    }
}
