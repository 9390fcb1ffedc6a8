//! The best set of effects, with all that depends on what is uncertain beside it.

use crate::discovery::fit::candidate::effects;
use crate::discovery::fit::gauss_newton::{Fitted, Study};
use crate::discovery::fit::nuisance::Nuisances;
use crate::discovery::fit::simulate;
use crate::discovery::goodness_of_fit::Left;
use crate::discovery::goodness_of_fit::cross_trial::Missing;
use crate::discovery::problem::Question;
use crate::discovery::recording::samples::Samples;
use crate::discovery::search::Found;
use crate::effects::EffectSpec;

/// What is found out about a set before it is an answer.
pub(crate) struct About {
    /// The set, fitted as finely as can be.
    pub(crate) fine: Fine,
    /// Whether what it leaves can be foretold.
    pub(crate) missing: Missing,
    /// Whether it leaves more than nuisances and noise in any way.
    pub(crate) left: Left,
}

/// A set with all that its last fit depends on.
pub(crate) struct Fine {
    /// The samples, without what the search's steps in time and cells are off by with the set.
    pub(crate) samples: Samples,
    /// What may differ a little from the model with the set.
    pub(crate) nuisances: Nuisances,
    /// The set, fitted with those.
    pub(crate) fitted: Fitted,
}

impl Question<'_> {
    /// All about the set that fits `best`.
    pub(crate) fn about(&self, best: &Fitted) -> About {
        let fine = self.finely(best);
        let Fine { samples, nuisances, fitted } = &fine;
        let fitted = self.study_of(samples, nuisances).outward(fitted.clone());
        let fine = Fine { fitted, ..fine };
        let missing = self.foretold(&fine.fitted.explained, &fine.fitted.played);
        let left = self.left(&fine.nuisances, &fine.fitted, &missing);
        About { fine, missing, left }
    }

    /// The set fitted with samples and nuisances as they are beside it: comparisons, tests and intervals depend on them.
    pub(crate) fn finely(&self, near: &Fitted) -> Fine {
        let nuisances = if near.members.is_empty() {
            self.nuisances.clone()
        } else {
            self.nuisances_beside(&near.members, &self.fit, &self.played)
        };
        let (samples, nuisances) = self.about_where_they_are(near, nuisances);
        match self.study_of(&samples, &nuisances).refit(near.members.clone(), near.jacobian.clone()) {
            Some(fitted) => Fine { samples, nuisances, fitted },
            None => {
                let fitted = self.study().sharpened(near.clone()).unwrap_or_else(|| near.clone());
                Fine { samples: self.fit.clone(), nuisances: self.nuisances.clone(), fitted }
            }
        }
    }

    fn study_of<'s>(&'s self, samples: &'s Samples, nuisances: &'s Nuisances) -> Study<'s> {
        Study { nuisances, samples, ..self.study() }
    }

    /// The samples without what the search's steps in time and cells are off by beside the set, and its `nuisances`, linear
    /// about where they are; as they are where the set cannot be played so finely.
    fn about_where_they_are(&self, best: &Fitted, nuisances: Nuisances) -> (Samples, Nuisances) {
        let known = effects(&self.hypotheses, &best.members).unwrap_or_default();
        let fine = |off: &[EffectSpec]| simulate::fine_tips(&self.model, &[&known, off].concat(), &self.fit);
        let Some(here) = fine(&[]) else { return (self.fit.clone(), nuisances) };
        let samples = simulate::corrected(&self.fit, &here, &best.played);
        let amounts = self.study_of(&samples, &nuisances).explained(&best.members, &best.played).amounts;
        let nuisances = self.uncertain(&best.members).bent(nuisances, &amounts, &here, &fine);
        (samples, nuisances)
    }
}

impl About {
    /// What was found, with its best set as it was fitted last.
    pub(crate) fn refined(&self, mut found: Found) -> Found {
        let members = std::mem::replace(&mut found.best.fitted, self.fine.fitted.clone()).members;
        let own = found.tried.iter_mut().filter(|scored| scored.fitted.members == members);
        own.for_each(|scored| *scored = found.best.clone());
        found
    }
}
