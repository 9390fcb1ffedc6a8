//! The best set of effects, with all that depends on what is uncertain beside it.

use nalgebra::DVector;

use super::hypothesis::effects;
use super::left::Left;
use super::missing::Missing;
use super::nuisance::Nuisances;
use super::play;
use super::question::Question;
use super::refit::{Fitted, Study};
use super::samples::Samples;
use super::samples::rms_m;
use super::search::Found;
use crate::effects::EffectSpec;

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
        let effects = effects(&self.hypotheses, &best.members).unwrap_or_default();
        let as_given = best.members.is_empty();
        let linear = if as_given {
            self.nuisances.clone()
        } else {
            self.nuisances_beside(&best.members, &self.fit, &self.played)
        };
        let (samples, nuisances) = self.about_where_they_are(best, &effects, linear);
        let study = Study { nuisances: &nuisances, samples: &samples, ..self.study() };
        match study.refit(best.members.clone(), best.jacobian.clone()).map(|fitted| study.outward(fitted)) {
            Some(fitted) => (samples, nuisances, fitted),
            None => {
                let fitted = self.study().sharpened(best.clone()).unwrap_or_else(|| best.clone());
                (self.fit.clone(), self.nuisances.clone(), fitted)
            }
        }
    }

    /// The samples without what the search's steps in time and cells are off by beside the set, and its nuisances, linear about
    /// where they are; as far as that can be played and they bend by more than plays are exact to.
    fn about_where_they_are(&self, best: &Fitted, known: &[EffectSpec], linear: Nuisances) -> (Samples, Nuisances) {
        let corrected =
            |off: &[EffectSpec]| play::corrected(&self.model, &[known, off].concat(), &self.fit, &best.played);
        let straight = corrected(&[]).unwrap_or_else(|| self.fit.clone());
        let study = Study { nuisances: &linear, samples: &straight, ..self.study() };
        let amounts = study.explained(&best.members, &best.played).amounts;
        let there = self.uncertain(&best.members).at(&linear, &amounts);
        let Some((samples, told)) = there.and_then(|(off, told)| Some((corrected(&off)?, told))) else {
            return (straight, linear);
        };
        let bend: Vec<f64> = straight.residual(&told_and(&samples, &told));
        if rms_m(&bend) < self.options.motion_tolerance_m {
            return (straight, linear);
        }
        (samples, linear.bent(-told))
    }
}

/// The tips of the `samples` with so much added, three numbers a sample.
fn told_and(samples: &Samples, told: &DVector<f64>) -> Vec<f64> {
    samples.rows.iter().flat_map(|row| row.tip_m).zip(told.iter()).map(|(tip, told)| tip + told).collect()
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
