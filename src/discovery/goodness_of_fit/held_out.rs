//! Variance test on held-out trials: do they scatter more about an answer than the trials it was
//! fitted to?

use super::test_result::{FitTest, TestResult};
use crate::discovery::fit::candidate::effect_specs;
use crate::discovery::fit::gauss_newton::{FitProblem, FittedSet};
use crate::discovery::fit::nuisance::NuisanceFit;
use crate::discovery::fit::simulate;
use crate::discovery::problem::Problem;
use crate::discovery::recording::samples::Samples;
use crate::effects::EffectSpec;
use crate::math::distribution::f_above;

impl Problem<'_> {
    /// Fit of the held-out residual by nuisance parameters with the posterior of the training fit.
    /// `simulated_m`: simulated tip of the `answer`.
    pub(crate) fn explain_held_out(
        &self,
        fit_problem: &FitProblem,
        answer: &FittedSet,
        simulated_m: &[f64],
    ) -> Option<NuisanceFit> {
        let precision = fit_problem.nuisance_precision(answer)?;
        let beside =
            self.nuisances_with(&answer.members, &self.held_out, &self.held_out_simulated_m);
        let amounts = &answer.nuisance_fit.amounts;
        let members = effect_specs(&self.candidates, &answer.members).unwrap_or_default();
        let play = |more: &[EffectSpec]| {
            simulate::tips(&self.model, &[&members, more].concat(), &self.held_out)
        };
        let nuisances =
            self.uncertain(&answer.members).linearised_at(beside, amounts, simulated_m, &play);
        // What is uncertain stays within what the training fit has left of it.
        let nuisances = nuisances.with_prior(amounts.clone(), precision);
        Some(nuisances.explain(&self.held_out, &self.held_out.residual(simulated_m), 0.0))
    }

    /// Whether `other` values of an answer pass the test on held-out trials.
    pub(crate) fn passes_held_out_test(&self, fit_problem: &FitProblem, other: &FittedSet) -> bool {
        let effects = effect_specs(&self.candidates, &other.members);
        let simulated_m =
            effects.and_then(|effects| simulate::tips(&self.model, &effects, &self.held_out));
        let unseen = simulated_m
            .and_then(|simulated_m| self.explain_held_out(fit_problem, other, &simulated_m));
        unseen.is_some_and(|unseen| self.held_out_test(other, &unseen).is_none())
    }

    /// The failed test, if held-out trials scatter significantly more about `answer` than the
    /// training trials. `unseen`: fit of the held-out residual.
    pub(crate) fn held_out_test(
        &self,
        answer: &FittedSet,
        unseen: &NuisanceFit,
    ) -> Option<TestResult> {
        let freedom = |fit: &NuisanceFit, samples: &Samples| fit.noise.freedom(samples.len());
        let [unseen_m2, fitted_m2] =
            [unseen, &answer.nuisance_fit].map(|fit| fit.noise.rms_m().powi(2));
        let (above, below) =
            (freedom(unseen, &self.held_out), freedom(&answer.nuisance_fit, &self.training));
        let result = TestResult {
            test: FitTest::HeldOut,
            p_value: f_above(unseen_m2 / fitted_m2, above, below),
            more_m: (unseen_m2 - fitted_m2).max(0.0).sqrt(),
            beyond_m: fitted_m2.sqrt(),
        };
        // No law is exact, so held-out trials may be worse by the expected law error.
        let min_m =
            self.least_relevant_m(result.beyond_m).max(self.law_error_m(&answer.simulated_m));
        Some(result).filter(|result| result.is_failed(self.options.false_alarm, min_m))
    }
}
