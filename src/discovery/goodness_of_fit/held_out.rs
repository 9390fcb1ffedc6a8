//! Variance test on held-out trials: do they scatter more about an answer than the trials it was fitted to?

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
    /// Fit of the held-out residual by nuisance parameters with the posterior of the training fit. `simulated_m`:
    /// simulated tip of the `answer`.
    pub(crate) fn explain_held_out(
        &self,
        fit_problem: &FitProblem,
        answer: &FittedSet,
        simulated_m: &[f64],
    ) -> Option<NuisanceFit> {
        let precision = fit_problem.nuisance_precision(answer)?;
        let beside = self.nuisances_with(&answer.members, &self.held_out, &self.held_out_simulated_m);
        let amounts = &answer.nuisance_fit.amounts;
        let known = effect_specs(&self.candidates, &answer.members).unwrap_or_default();
        let there = |off: &[EffectSpec]| simulate::tips(&self.model, &[&known, off].concat(), &self.held_out);
        let nuisances = self.uncertain(&answer.members).linearised_at(beside, amounts, simulated_m, &there);
        let nuisances = nuisances.with_prior(amounts.clone(), precision);
        Some(nuisances.explain(&self.held_out, &self.held_out.residual(simulated_m), 0.0))
    }

    /// Whether `other` values of an answer pass the test on held-out trials.
    pub(crate) fn is_borne_out_by_held_out(&self, fit_problem: &FitProblem, other: &FittedSet) -> bool {
        let known = effect_specs(&self.candidates, &other.members);
        let simulated_m = known.and_then(|known| simulate::tips(&self.model, &known, &self.held_out));
        let unseen = simulated_m.and_then(|simulated_m| self.explain_held_out(fit_problem, other, &simulated_m));
        unseen.is_some_and(|unseen| self.held_out_test(other, &unseen).is_none())
    }

    /// The failed test, if held-out trials scatter significantly more about `answer` than the training trials.
    /// `unseen`: fit of the held-out residual.
    pub(crate) fn held_out_test(&self, answer: &FittedSet, unseen: &NuisanceFit) -> Option<TestResult> {
        let square_m2 = |nuisance_fit: &NuisanceFit| nuisance_fit.noise.rms_m().powi(2);
        let freedom = |nuisance_fit: &NuisanceFit, samples: &Samples| nuisance_fit.noise.freedom(samples.len());
        let (there, here) = (square_m2(unseen), square_m2(&answer.nuisance_fit));
        let above = freedom(unseen, &self.held_out);
        let p_value = f_above(there / here, above, freedom(&answer.nuisance_fit, &self.training));
        let least_m = self.least_relevant_m(here.sqrt()).max(self.law_error_m(&answer.simulated_m));
        let more_m = (there - here).max(0.0).sqrt();
        let clear = p_value < self.options.false_alarm && more_m > least_m;
        clear.then_some(TestResult { test: FitTest::HeldOut, p_value, more_m, beyond_m: here.sqrt() })
    }
}
