//! The best set of effects, with all that depends on what is uncertain beside it.

use super::hypothesis::effects;
use super::left::Left;
use super::missing::Missing;
use super::nuisance::Nuisances;
use super::play;
use super::question::Question;
use super::refit::{Fitted, Study};
use super::samples::Samples;
use super::search::Found;

/// What is found out about a set before it is an answer.
pub(super) struct About {
    /// The samples, without what the search's steps in time and cells are off by with the set.
    pub(super) samples: Samples,
    /// What may differ a little from the model with the set.
    pub(super) nuisances: Nuisances,
    /// The set, fitted with those.
    pub(super) fitted: Fitted,
    /// Whether what it leaves can be foretold.
    pub(super) missing: Missing,
    /// Whether it leaves more than nuisances and noise in any way.
    pub(super) left: Left,
}

impl Question<'_> {
    /// All about the set that fits `best`.
    pub(super) fn about(&self, best: &Fitted) -> About {
        let (samples, nuisances, fitted) = self.beside(best);
        let missing = self.foretold(&fitted.explained, &fitted.played);
        let left = self.left(&nuisances, &fitted, &missing);
        About { samples, nuisances, fitted, missing, left }
    }

    /// The samples and the nuisances as they are beside the set, and the set fitted with those: tests and intervals depend on
    /// them.
    fn beside(&self, best: &Fitted) -> (Samples, Nuisances, Fitted) {
        let as_given = |fitted: Fitted| (self.fit.clone(), self.nuisances.clone(), fitted);
        let effects = match effects(&self.hypotheses, &best.members) {
            Some(effects) if !effects.is_empty() => effects,
            _ => return as_given(best.clone()),
        };
        let samples = play::corrected(&self.model, &effects, &self.fit, &best.played);
        let nuisances = self.nuisances_beside(&best.members, &self.fit, &self.played);
        let study = Study { nuisances: &nuisances, samples: &samples, ..self.study() };
        match study.refit(best.members.clone(), best.jacobian.clone()).map(|fitted| study.outward(fitted)) {
            Some(fitted) => (samples, nuisances, fitted),
            None => as_given(self.study().sharpened(best.clone()).unwrap_or_else(|| best.clone())),
        }
    }
}

impl About {
    /// What was found, with its best set as it was fitted last.
    pub(super) fn refined(&self, mut found: Found) -> Found {
        let members = std::mem::replace(&mut found.best.fitted, self.fitted.clone()).members;
        let own = found.tried.iter_mut().filter(|scored| scored.fitted.members == members);
        own.for_each(|scored| *scored = found.best.clone());
        found
    }
}
