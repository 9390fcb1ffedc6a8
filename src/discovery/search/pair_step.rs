//! Pairs that no single effect led to: what was found first may stand for two others, of which neither does much beside it,
//! or one may make the other look as if it were somewhere else.

use std::collections::BTreeSet;

use super::screening::Promise;
use super::swap::with;
use super::{Scored, Search};
use crate::discovery::fit::candidate::set_of;

/// Pairs that are fitted besides those with a member of the answer, the most promising ones.
const PAIRS: usize = 16;

impl Search<'_> {
    /// `best`, or what comes of the best pair that was not on the way to it, if that is better.
    pub(crate) fn paired_otherwise(&mut self, best: Scored) -> Scored {
        if self.limits.most_effects < 2 {
            return best;
        }
        let enough = self.enough_of(2, &best);
        let mut pairs: Vec<Scored> = Vec::new();
        for (single, promises) in self.promising_pairs(&set_of(&best.fitted.members)) {
            pairs.extend(self.fitted_with(&single, &promises, enough));
        }
        pairs.retain(|pair| pair.score > enough);
        pairs.sort_by(|a, b| b.score.total_cmp(&a.score));
        match pairs.into_iter().find(|pair| self.is_each_worth(pair)) {
            Some(pair) => {
                let pair = self.swapped(pair);
                self.enlarged(pair)
            }
            None => best,
        }
    }

    /// Whether either member is worth having beside the other.
    fn is_each_worth(&mut self, pair: &Scored) -> bool {
        (0..2).all(|out| self.without(pair, out).is_some_and(|rest| self.is_worth(&rest, pair)))
    }

    /// What is promised beside the single effects that have been fitted, by that effect, where such a pair has not been
    /// fitted: all pairs with one of `members`, and of the others those that promise most, score and all.
    fn promising_pairs(&self, members: &BTreeSet<usize>) -> Vec<(Scored, Vec<Promise>)> {
        let singles = self.singles();
        let mut pairs: Vec<(f64, usize, Promise)> = Vec::new();
        for (number, single) in singles.iter().enumerate() {
            let promises = self.study.promises(&single.fitted, &[], &self.responses).into_iter();
            let new = promises.filter(|promise| !self.is_tried(single, promise));
            pairs.extend(new.map(|promise| (single.score + self.study.promised(&promise), number, promise)));
        }
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (mut seen, mut others) = (BTreeSet::new(), 0..PAIRS);
        pairs.retain(|(_, single, promise)| {
            let pair = with(singles[*single], promise);
            let beside_member = !pair.is_disjoint(members);
            seen.insert(pair) && (beside_member || others.next().is_some())
        });
        let beside = |number: usize| -> Vec<Promise> {
            pairs.iter().filter(|pair| pair.1 == number).map(|pair| pair.2.clone()).collect()
        };
        let with_promises = singles.iter().enumerate().map(|(number, &single)| (single, beside(number)));
        let kept = with_promises.filter(|(_, promises)| !promises.is_empty());
        kept.map(|(single, promises)| (single.clone(), promises)).collect()
    }

    /// The single effects that have been fitted, each as it fits best.
    fn singles(&self) -> Vec<&Scored> {
        let mut singles: Vec<&Scored> = self.tried.iter().filter(|scored| scored.fitted.members.len() == 1).collect();
        singles.sort_by(|a, b| b.score.total_cmp(&a.score));
        let mut seen = BTreeSet::new();
        singles.retain(|single| seen.insert(set_of(&single.fitted.members)));
        singles
    }
}
