//! A set with one member more, if that is worth having.

use std::collections::BTreeSet;

use super::{Scored, Search};
use crate::discovery::fit::candidate::set_of;
use crate::discovery::fit::gauss_newton::Fitted;
use crate::discovery::recording::samples::rms_m;

impl Search<'_> {
    /// `base` with the best member more, if that is worth having and its score `enough`.
    pub(crate) fn with_another(&mut self, base: &Scored, enough: f64) -> Option<Scored> {
        let limits = self.limits;
        let mut promises = self.study.promises(&base.fitted, &[], &self.responses);
        // What has been fitted beside this set before, on the way to another one too, is not fitted again.
        promises.retain(|promise| !self.is_tried(base, promise));
        if !self.is_thorough(base) {
            promises.retain(|promise| self.study.is_worth_fitting(promise, &base.fitted, &limits));
        }
        let unsettled = self.fitted_with(base, &promises, enough).into_iter().filter(|fit| !fit.exact);
        let mut fits: Vec<Scored> = unsettled.chain(self.larger(base).cloned()).collect();
        fits.retain(|next| next.score >= enough);
        fits.sort_by(|a, b| b.score.total_cmp(&a.score));
        fits.into_iter().find(|next| self.is_worth(base, next)).or_else(|| self.of_the_rough(base, enough))
    }

    /// The sets of `base` and one member more that have been fitted as well as can be.
    pub(crate) fn larger(&self, base: &Scored) -> impl Iterator<Item = &Scored> {
        let members = set_of(&base.fitted.members);
        self.tried.iter().filter(move |scored| scored.exact && is_larger(scored, &members))
    }

    /// The best of those that were left as they were fitted roughly, because another one promised more.
    fn of_the_rough(&mut self, base: &Scored, enough: f64) -> Option<Scored> {
        let members = set_of(&base.fitted.members);
        let mut rough: Vec<usize> = (0..self.tried.len()).collect();
        rough.retain(|&k| !self.tried[k].exact && self.tried[k].score >= enough && is_larger(&self.tried[k], &members));
        rough.sort_by(|&a, &b| self.tried[b].score.total_cmp(&self.tried[a].score));
        rough.into_iter().find_map(|k| {
            self.settle(k);
            let settled = self.tried[k].clone();
            (settled.exact && settled.score >= enough && self.is_worth(base, &settled)).then_some(settled)
        })
    }

    /// Whether `next`, which is `base` with one member more, is worth having: that one moves the tip by enough itself, and
    /// takes it from where the others have it by more than their laws are off.
    pub(crate) fn is_worth(&self, base: &Scored, next: &Scored) -> bool {
        let inexact_m = self.limits.least_share * apart_m(&base.fitted, &self.null.fitted);
        if apart_m(&next.fitted, &base.fitted) < inexact_m {
            return false;
        }
        let added = next.fitted.members.iter().position(|member| !base.fitted.has(member.hypothesis));
        let rest = added.and_then(|added| self.study.without(&next.fitted, added));
        let least_m = self.limits.least_m(&next.fitted.explained.noise);
        rest.is_some_and(|rest| apart_m(&next.fitted, &rest) >= least_m)
    }
}

/// How far the tips of two fits are from each other, root mean square, metres.
fn apart_m(there: &Fitted, here: &Fitted) -> f64 {
    let moved: Vec<f64> = there.played.iter().zip(&here.played).map(|(there, here)| there - here).collect();
    rms_m(&moved)
}

/// Whether a set is the `members` and one more.
fn is_larger(scored: &Scored, members: &BTreeSet<usize>) -> bool {
    let own = set_of(&scored.fitted.members);
    own.len() == members.len() + 1 && own.is_superset(members)
}
