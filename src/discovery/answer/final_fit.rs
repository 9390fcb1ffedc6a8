//! Final fit of the best set, at fine resolution and with nuisance parameters relinearised.

use crate::discovery::fit::candidate::effect_specs;
use crate::discovery::fit::gauss_newton::{FitProblem, FittedSet};
use crate::discovery::fit::nuisance::Nuisances;
use crate::discovery::fit::simulate;
use crate::discovery::goodness_of_fit::GoodnessOfFit;
use crate::discovery::goodness_of_fit::cross_trial::CrossTrialTest;
use crate::discovery::problem::Problem;
use crate::discovery::recording::samples::Samples;
use crate::discovery::search::SearchOutcome;
use crate::effects::EffectSpec;

/// Final fit of a set with its tests.
pub(crate) struct FinalFit {
    /// The set fitted at fine resolution.
    pub(crate) fine: FineFit,
    /// Result of the cross-trial test.
    pub(crate) cross_trial: CrossTrialTest,
    /// Result of all tests.
    pub(crate) goodness: GoodnessOfFit,
}

/// A fitted set with the data that it depends on.
pub(crate) struct FineFit {
    /// Samples corrected for the discretisation error of the search.
    pub(crate) samples: Samples,
    /// Nuisance parameters given the set.
    pub(crate) nuisances: Nuisances,
    /// The set fitted to those.
    pub(crate) fitted: FittedSet,
}

impl Problem<'_> {
    /// Final fit and tests of the set that fits `best`.
    pub(crate) fn final_fit(&self, best: &FittedSet) -> FinalFit {
        let fine = self.refit_finely(best);
        let FineFit { samples, nuisances, fitted } = &fine;
        // The tip may jump where tendons become taut, and derivatives do not lead across.
        let fitted = self.fit_problem_with(samples, nuisances).step_out(fitted.clone());
        let fine = FineFit { fitted, ..fine };
        // Only the stepped-out fit is tested: a poorer local optimum would be rejected wrongly.
        let cross_trial =
            self.cross_trial_test(&fine.fitted.nuisance_fit, &fine.fitted.simulated_m);
        let goodness = self.goodness_of_fit(&fine.nuisances, &fine.fitted, &cross_trial);
        FinalFit { fine, cross_trial, goodness }
    }

    /// Refits the set with corrected samples and relinearised nuisance parameters.
    pub(crate) fn refit_finely(&self, start: &FittedSet) -> FineFit {
        // Strong effects change the answers of the tip to what is uncertain.
        let nuisances = if start.members.is_empty() {
            self.nuisances.clone()
        } else {
            self.nuisances_with(&start.members, &self.training, &self.simulated_m)
        };
        let (samples, nuisances) = self.corrected_and_relinearised(start, nuisances);
        match self
            .fit_problem_with(&samples, &nuisances)
            .refit(start.members.clone(), start.jacobian.clone())
        {
            Some(fitted) => FineFit { samples, nuisances, fitted },
            // At the limits of what can be simulated the fit of the search stands.
            None => {
                let fitted = self
                    .fit_problem()
                    .with_fresh_jacobian(start.clone())
                    .unwrap_or_else(|| start.clone());
                FineFit {
                    samples: self.training.clone(),
                    nuisances: self.nuisances.clone(),
                    fitted,
                }
            }
        }
    }

    fn fit_problem_with<'s>(
        &'s self,
        samples: &'s Samples,
        nuisances: &'s Nuisances,
    ) -> FitProblem<'s> {
        FitProblem { nuisances, samples, ..self.fit_problem() }
    }

    /// Samples corrected for the discretisation error of the search, and nuisance parameters
    /// linearised at their estimates; unchanged if the fine simulation fails.
    fn corrected_and_relinearised(
        &self,
        best: &FittedSet,
        nuisances: Nuisances,
    ) -> (Samples, Nuisances) {
        let members = effect_specs(&self.candidates, &best.members).unwrap_or_default();
        let fine = |more: &[EffectSpec]| {
            simulate::fine_tips(&self.model, &[&members, more].concat(), &self.training)
        };
        let Some(fine_m) = fine(&[]) else { return (self.training.clone(), nuisances) };
        // 1. Defect correction: later fits at search resolution aim at the fine solution.
        let samples = simulate::corrected(&self.training, &fine_m, &best.simulated_m);
        // 2. Estimate the nuisance parameters beside the set.
        let amounts = self
            .fit_problem_with(&samples, &nuisances)
            .fit_nuisances(&best.members, &best.simulated_m)
            .amounts;
        // 3. Play them there, and keep what the linear columns miss as an offset.
        let nuisances =
            self.uncertain(&best.members).linearised_at(nuisances, &amounts, &fine_m, &fine);
        (samples, nuisances)
    }
}

impl FinalFit {
    /// The outcome with its best set as finally fitted.
    pub(crate) fn replace_best(&self, mut outcome: SearchOutcome) -> SearchOutcome {
        let members = std::mem::replace(&mut outcome.best.fitted, self.fine.fitted.clone()).members;
        // The table of candidates must show the numbers of the answer.
        let entries = outcome.tried.iter_mut().filter(|scored| scored.fitted.members == members);
        entries.for_each(|scored| *scored = outcome.best.clone());
        outcome
    }
}
