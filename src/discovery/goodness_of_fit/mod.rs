//! Whether a set of effects leaves more of the samples than nuisances and noise: six tests, each of which sees what others
//! miss.

pub(crate) mod cross_trial;
pub(crate) mod held_out;
pub(crate) mod kernel_ridge;
pub(crate) mod lack_of_fit;
pub(crate) mod levene;
pub(crate) mod score_test;
pub(crate) mod spearman;
pub(crate) mod test_result;

use nalgebra::{DMatrix, DVectorView};

use super::fit::candidate::SetMember;
use super::fit::gauss_newton::FittedSet;
use super::fit::nuisance::{NuisanceFit, Nuisances};
use super::noise_floor::NoiseFloor;
use super::problem::Problem;
use super::recording::covariates::sample_covariates;
use cross_trial::{CrossTrialTest, test_cross_trial};
use lack_of_fit::lack_of_fit_test;
use levene::levene_test;
use score_test::score_test;
use spearman::spearman_test;
use test_result::{FitTest, TestResult};

/// Whether something is left.
#[derive(Clone, Debug)]
pub(crate) struct GoodnessOfFit {
    /// The clearest failed of it, by a chance below `false_alarm`, or that it is slower than any noise.
    pub(crate) failed: Option<TestResult>,
    /// By one that is worth a longer search.
    pub(crate) is_doubtful: bool,
    /// What all effects together would certainly explain of it, but no more than laws may be off by, metres.
    pub(crate) tolerated_m: Option<f64>,
    /// The noise floor that it was held against.
    pub(crate) floor: NoiseFloor,
}

/// Correlation from one sample to the next beyond which what is left is not a tracker's noise.
const SLOW: f64 = 0.8;
/// Chance below which such a residual is more than the repeats' noise.
const SLOW_CHANCE: f64 = 0.05;
/// Chance of any test below which the search goes on before it says that nothing is missing.
const DOUBTFUL: f64 = 0.05;
/// Laws of how a rod gives way stand for many; effects without a shape or a place are off by this share of `least_share`.
const WITHOUT_SHAPE: f64 = 0.5;

impl GoodnessOfFit {
    /// Whether it is more than noise leaves.
    pub(crate) fn is_rejected(&self) -> bool {
        self.failed.is_some()
    }
}

impl Problem<'_> {
    /// Whether what is left of the samples of the fit can be foretold.
    pub(crate) fn cross_trial_test(&self, nuisance_fit: &NuisanceFit, simulated_m: &[f64]) -> CrossTrialTest {
        let covariates = sample_covariates(&self.training, simulated_m);
        test_cross_trial(&self.training, &covariates, &nuisance_fit.residual_m, self.options.seed())
    }

    /// Whether `fitted` leaves more than the `nuisances` beside it and noise; `foretold`: what can be foretold of it.
    pub(crate) fn goodness_of_fit(
        &self,
        nuisances: &Nuisances,
        fitted: &FittedSet,
        foretold: &CrossTrialTest,
    ) -> GoodnessOfFit {
        let nuisance_fit = &fitted.nuisance_fit;
        let floor_m = nuisance_fit.noise.rms_m();
        let model_m = self.options.least_m(&self.model);
        let least_m = self.least_relevant_m(floor_m);
        let inexact_m = least_m.max(self.allowed_law_error_m(fitted, 1.0));
        // More scatter than noise alone; scatter that hardly changes from one sample to the next is no tracker's, and little
        // more of it is enough.
        let floor = NoiseFloor::estimate(&self.training, nuisance_fit, &fitted.simulated_m);
        let scatters = floor.p_value_of(&NoiseFloor::of_residual(nuisance_fit, &self.training));
        let alone_m = floor.rms_m();
        let more_m = (floor_m.powi(2) - alone_m.powi(2)).max(0.0).sqrt();
        let slow = nuisance_fit.noise.correlation > SLOW && scatters < SLOW_CHANCE && more_m > model_m;
        let spread = levene_test(&self.training, nuisance_fit);
        let bias = lack_of_fit_test(&self.training, &nuisance_fit.residual_m, &nuisance_fit.noise, &floor);
        let grows = spearman_test(nuisance_fit, &self.displacement_m(&fitted.simulated_m));
        let all = score_test(&self.training, nuisances, fitted, &self.catalogue_sensitivities());
        let (all, all_m) = all.map_or((1.0, 0.0), |found| (found.p_value, found.more_m));
        // That is only the part of what is left that the catalogue reaches, and not held against the noise floor.
        let shaped = fitted.members.iter().any(|member| self.candidates[member.candidate].has_shape());
        let tolerable_m = model_m.max(self.allowed_law_error_m(fitted, if shaped { 1.0 } else { WITHOUT_SHAPE }));
        let seen = |test, p_value, more_m, beyond_m| TestResult { test, p_value, more_m, beyond_m };
        // What each test found, and how large it must be to matter.
        let tests = [
            (seen(FitTest::CrossTrial, foretold.test.p_value, foretold.test.foretold_m, 0.0), least_m),
            (seen(FitTest::Variance, scatters, more_m, alone_m), least_m),
            (seen(FitTest::Levene, spread.p_value, spread.more_m, spread.middle_m), inexact_m),
            (seen(FitTest::LackOfFit, bias.p_value, bias.rms_m, 0.0), inexact_m),
            (seen(FitTest::Score, all, all_m, 0.0), tolerable_m),
            (seen(FitTest::Spearman, grows.p_value, grows.more_m, grows.least_m), inexact_m),
        ];
        let below = |chance: f64| {
            let clear =
                tests.iter().filter(|(failed, matters_m)| failed.more_m > *matters_m && failed.p_value < chance);
            clear.map(|(failed, _)| *failed).min_by(|a, b| a.p_value.total_cmp(&b.p_value))
        };
        let failed =
            below(self.options.false_alarm).or(slow.then(|| seen(FitTest::SlowVariance, scatters, more_m, alone_m)));
        let is_doubtful = failed.or(below(DOUBTFUL / tests.len() as f64)).is_some();
        let is_tolerated = all < self.options.false_alarm && all_m > model_m && all_m <= tolerable_m;
        GoodnessOfFit { failed, is_doubtful, tolerated_m: is_tolerated.then_some(all_m), floor }
    }

    /// What the laws of the members may be off by, metres: this `share` of what laws are off by at their best. Nothing where
    /// a size would go on beyond the end of its range: that is no law's error.
    fn allowed_law_error_m(&self, fitted: &FittedSet, share: f64) -> f64 {
        let ended = |member: &SetMember| self.candidates[member.candidate].is_at_range_end(&member.values);
        if fitted.members.iter().any(ended) { 0.0 } else { share * self.law_error_m(&fitted.simulated_m) }
    }

    /// How the tip answers to a little of every effect that could be the answer, a column a size. Not of those that are
    /// uncertain: together they would tell how uncertain, which is the lab's to say.
    fn catalogue_sensitivities(&self) -> DMatrix<f64> {
        let open = self.fit_problem().open;
        let asked = |number: usize| open[number] && !self.options.is_uncertain(self.candidates[number].card.name);
        let own = self.sensitivities.iter().filter(|sensitivity| asked(sensitivity.candidate));
        let columns: Vec<DVectorView<f64>> = own.flat_map(|sensitivity| sensitivity.columns.column_iter()).collect();
        DMatrix::from_fn(3 * self.training.len(), columns.len(), |row, k| columns[k][row])
    }
}
