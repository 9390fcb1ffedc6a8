//! The check of the best set on held-out trials.

use super::verdict::HeldOutResult;
use crate::discovery::fit::candidate::{SetMember, effect_specs};
use crate::discovery::fit::gauss_newton::{FitProblem, FittedSet};
use crate::discovery::fit::nuisance::NuisanceFit;
use crate::discovery::fit::simulate;
use crate::discovery::problem::Problem;
use crate::discovery::recording::samples::rms_m;

/// Held-out trials beside a set of effects.
pub(crate) struct HeldOutCheck {
    /// Rms error of the model with the set, metres.
    pub(crate) after_m: f64,
    /// Simulated tip with the set, three values a sample, metres.
    pub(crate) simulated_m: Vec<f64>,
    /// Residual without uncertain parameters and errors shared with the baseline, where it was
    /// fitted.
    pub(crate) residual: Option<NuisanceFit>,
    pub(crate) result: HeldOutResult,
}

impl Problem<'_> {
    /// Rms held-out error of the given model, metres.
    pub(crate) fn held_out_before_m(&self) -> f64 {
        rms_m(&self.held_out.residual(&self.held_out_simulated_m))
    }

    /// Held-out trials of the given model, where no set is checked on them.
    pub(crate) fn held_out_unchecked(&self, result: HeldOutResult) -> HeldOutCheck {
        let simulated_m = self.held_out_simulated_m.clone();
        HeldOutCheck { after_m: self.held_out_before_m(), simulated_m, residual: None, result }
    }

    /// Checks the set `best`, which would be written with the values of `members`, on held-out
    /// trials.
    pub(crate) fn validate_on_held_out(
        &self,
        fit_problem: &FitProblem,
        best: &FittedSet,
        members: &[SetMember],
    ) -> HeldOutCheck {
        let effects = effect_specs(&self.candidates, members).unwrap_or_default();
        let tips = |model| simulate::tips(model, &effects, &self.held_out);
        // At the limits of what can be simulated the resolution decides.
        let Some(simulated_m) = tips(&self.model).or_else(|| tips(&self.coarse)) else {
            return self.held_out_unchecked(HeldOutResult::CannotSimulate);
        };
        let after_m = rms_m(&self.held_out.residual(&simulated_m));
        // An error that is not a number is worse, too.
        let is_no_worse = after_m <= self.held_out_before_m();
        if !is_no_worse {
            return HeldOutCheck {
                after_m,
                simulated_m,
                residual: None,
                result: HeldOutResult::Worse,
            };
        }
        let residual = self.explain_held_out(fit_problem, best, &simulated_m);
        let failed_test = residual.as_ref().and_then(|residual| self.held_out_test(best, residual));
        // If a tendon is always slack its zero is undetermined, and another value may pass.
        // This plays many fits, so it is asked only after a failed test.
        let is_tolerated = || {
            fit_problem
                .equally_good_fits(best)
                .iter()
                .any(|other| self.passes_held_out_test(fit_problem, other))
        };
        let result = match failed_test {
            None => HeldOutResult::Supported,
            Some(test) if is_tolerated() => HeldOutResult::Tolerated(test),
            Some(test) => HeldOutResult::Scattered(test),
        };
        HeldOutCheck { after_m, simulated_m, residual, result }
    }
}
