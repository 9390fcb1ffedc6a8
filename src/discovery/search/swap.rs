//! Moves from one set to another of as many effects or fewer: what was taken first may only stand for what comes later.

use std::collections::BTreeSet;

use super::screening::Promise;
use super::{Scored, Search, WIDTH};
use crate::discovery::fit::candidate::set_of;

impl Search<'_> {
    /// What is better than `best` of the larger sets that hold it, worth having or not, without one of its members: that one
    /// may have stood for what came last (floating search; Pudil, Novovičová & Kittler, Pattern Recognition Letters 15,
    /// 1994).
    pub(crate) fn instead(&mut self, best: &Scored) -> Option<Scored> {
        let members = set_of(&best.fitted.members);
        let larger = self.larger(best).filter(|larger| larger.score > best.score);
        let larger = larger.max_by(|a, b| a.score.total_cmp(&b.score)).cloned()?;
        let old = |&out: &usize| members.contains(&larger.fitted.members[out].hypothesis);
        let fewer: Vec<Scored> = (0..=members.len()).filter(old).filter_map(|out| self.without(&larger, out)).collect();
        fewer.into_iter().filter(|fewer| fewer.score > best.score).max_by(|a, b| a.score.total_cmp(&b.score))
    }

    /// The set with a member exchanged, as long as that helps: what was taken first may stand for two others.
    pub(crate) fn swapped(&mut self, mut best: Scored) -> Scored {
        if best.fitted.members.len() < 2 {
            return best;
        }
        loop {
            let mut better: Option<Scored> = None;
            for out in 0..best.fitted.members.len() {
                let enough = better.as_ref().map_or(best.score, |better| better.score);
                better = self.exchanged(&best, out, enough).or(better);
            }
            match better {
                Some(next) => best = next,
                None => return best,
            }
        }
    }

    /// The set with another member instead of number `out`, if its score is above `enough`. The others first as they are,
    /// which is right if that one only took another's place; of two, if that brings nothing, the other fitted anew, which
    /// is right if it made up for that one.
    fn exchanged(&mut self, best: &Scored, out: usize, enough: f64) -> Option<Scored> {
        let kept = self.study.without(&best.fitted, out).map(|rest| self.scored(rest));
        let gone = best.fitted.members[out].hypothesis;
        let width = WIDTH / best.fitted.members.len();
        if let Some(better) = kept.and_then(|rest| self.other_than(gone, &rest, enough, width)) {
            return Some(better);
        }
        let anew = if best.fitted.members.len() == 2 { self.without(best, out) } else { None };
        anew.and_then(|rest| self.other_than(gone, &rest, enough, width))
    }

    /// The best of `rest` with one of `width` promising members besides that is not `gone`, if its score is above `enough`.
    fn other_than(&mut self, gone: usize, rest: &Scored, enough: f64, width: usize) -> Option<Scored> {
        let mut promises = self.study.promises(&rest.fitted, &[gone], &self.responses);
        promises.retain(|promise| !self.is_fitted(rest, promise));
        promises.truncate(width);
        let fits = self.fitted_with(rest, &promises, enough);
        fits.into_iter().filter(|fit| fit.score > enough).max_by(|a, b| a.score.total_cmp(&b.score))
    }

    /// Whether `base` has been fitted with what is promised as well as can be.
    fn is_fitted(&self, base: &Scored, promise: &Promise) -> bool {
        let all = with(base, promise);
        self.tried.iter().any(|scored| scored.exact && set_of(&scored.fitted.members) == all)
    }

    /// Whether `base` has been fitted with what is promised, if only roughly from there.
    pub(crate) fn is_tried(&self, base: &Scored, promise: &Promise) -> bool {
        let (all, added) = (with(base, promise), promise.member.hypothesis);
        let from_here = |scored: &Scored| scored.fitted.members.last().is_some_and(|last| last.hypothesis == added);
        self.tried.iter().any(|scored| (scored.exact || from_here(scored)) && set_of(&scored.fitted.members) == all)
    }

    /// The set without the members that do not pay for themselves.
    pub(crate) fn pruned(&mut self, mut best: Scored) -> Scored {
        let mut k = 0;
        while best.fitted.members.len() > 1 && k < best.fitted.members.len() {
            match self.without(&best, k) {
                Some(fewer) if fewer.score + self.limits.least_score > best.score => best = fewer,
                _ => k += 1,
            }
        }
        best
    }

    /// The set without the member number `out`, fitted, unless it has been before.
    pub(crate) fn without(&mut self, best: &Scored, out: usize) -> Option<Scored> {
        let mut rest = best.fitted.members.clone();
        rest.remove(out);
        let wanted = set_of(&rest);
        let known = self.tried.iter().filter(|scored| scored.exact && set_of(&scored.fitted.members) == wanted);
        if let Some(known) = known.max_by(|a, b| a.score.total_cmp(&b.score)) {
            return Some(known.clone());
        }
        let fewer = self.scored(self.study.refit(rest, self.study.slopes_without(&best.fitted, out))?);
        self.tried.push(fewer.clone());
        Some(fewer)
    }
}

/// Which hypotheses are in `base` and what is promised beside it.
pub(crate) fn with(base: &Scored, promise: &Promise) -> BTreeSet<usize> {
    let mut all = set_of(&base.fitted.members);
    all.insert(promise.member.hypothesis);
    all
}
