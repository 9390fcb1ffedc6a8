//! The best set of effects, with all that depends on what is uncertain beside it.

use super::missing::Missing;
use super::nuisance::Nuisances;
use super::question::{Left, Question};
use super::refit::{Fitted, Study};
use super::search::Found;

/// What is found out about a set before it is an answer.
pub(super) struct About {
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
        let (nuisances, fitted) = self.beside(best);
        let (missing, left) = self.missing(&fitted.explained, &fitted.played);
        About { nuisances, fitted, missing, left }
    }

    /// The set fitted with the nuisances as they are beside it, and those: tests and intervals depend on them.
    fn beside(&self, best: &Fitted) -> (Nuisances, Fitted) {
        if best.members.is_empty() {
            return (self.nuisances.clone(), best.clone());
        }
        let nuisances = self.nuisances_beside(&best.members, &self.fit, &self.played);
        let study = Study { nuisances: &nuisances, ..self.study() };
        if let Some(fitted) = study.refit(best.members.clone(), best.jacobian.clone()) {
            return (nuisances, fitted);
        }
        (self.nuisances.clone(), self.study().sharpened(best.clone()).unwrap_or_else(|| best.clone()))
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
