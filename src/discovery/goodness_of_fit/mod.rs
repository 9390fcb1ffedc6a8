//! Goodness of fit: are the residuals of a fitted set noise? Six tests, one file each; `held_out` adds a seventh on
//! held-out trials.

pub(crate) mod baseline_sizes;
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
use baseline_sizes::BaselineSizes;
use cross_trial::{CrossTrialTest, test_cross_trial};
use lack_of_fit::lack_of_fit_test;
use levene::levene_test;
use score_test::score_test;
use spearman::spearman_test;
use test_result::{FitTest, TestResult};

/// Result of all tests.
#[derive(Clone, Debug)]
pub(crate) struct GoodnessOfFit {
    /// The failed test with the smallest p-value below `false_alarm`, or the slow-variance test.
    pub(crate) failed: Option<TestResult>,
    /// Whether a test is close enough to failing that the search goes on.
    pub(crate) is_doubtful: bool,
    /// Significant residual that all effects together explain, but within the expected law errors, metres.
    pub(crate) tolerated_m: Option<f64>,
    /// The noise floor of the tests.
    pub(crate) floor: NoiseFloor,
}

/// Correlation above which a residual is no tracker noise.
const SLOW: f64 = 0.8;
/// Significance level of the variance test for such a residual.
const SLOW_CHANCE: f64 = 0.05;
/// Significance level below which the search goes on.
const DOUBTFUL: f64 = 0.05;
/// Share of the expected law error for effects without shape or choice parameters, whose laws are more accurate.
const WITHOUT_SHAPE: f64 = 0.5;

impl GoodnessOfFit {
    /// Whether a test has failed.
    pub(crate) fn is_rejected(&self) -> bool {
        self.failed.is_some()
    }
}

impl Problem<'_> {
    /// Cross-trial test of the training residual.
    pub(crate) fn cross_trial_test(&self, nuisance_fit: &NuisanceFit, simulated_m: &[f64]) -> CrossTrialTest {
        let covariates = sample_covariates(&self.training, simulated_m);
        test_cross_trial(&self.training, &covariates, &nuisance_fit.residual_m, self.options.seed())
    }

    /// Runs all tests on the residual of `fitted`; `foretold`: result of the cross-trial test.
    pub(crate) fn goodness_of_fit(
        &self,
        nuisances: &Nuisances,
        fitted: &FittedSet,
        foretold: &CrossTrialTest,
    ) -> GoodnessOfFit {
        let nuisance_fit = &fitted.nuisance_fit;
        let floor_m = nuisance_fit.noise.rms_m();
        let model_m = self.model_error_m();
        let least_m = self.least_relevant_m(floor_m);
        let inexact_m = least_m.max(self.allowed_law_error_m(fitted, 1.0));
        // Variance above the noise floor. Little excess suffices if the residual is too slow for tracker noise.
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
        // The score test covers only the part that the catalogue explains, and is not relative to the noise floor.
        let shaped = fitted.members.iter().any(|member| self.candidates[member.candidate].has_shape());
        let tolerable_m = model_m.max(self.allowed_law_error_m(fitted, if shaped { 1.0 } else { WITHOUT_SHAPE }));
        let seen = |test, p_value, more_m, beyond_m| TestResult { test, p_value, more_m, beyond_m };
        // A robot that the model does not describe exactly does not follow the laws of its effects exactly either.
        let predictable_m = if self.model_form_m > 0.0 { inexact_m } else { least_m };
        let as_built = BaselineSizes::new(self);
        // Each test with its minimum relevant size.
        let tests = [
            (seen(FitTest::CrossTrial, foretold.test.p_value, foretold.test.foretold_m, 0.0), predictable_m),
            (seen(FitTest::Variance, scatters, more_m, alone_m), predictable_m),
            (seen(FitTest::Levene, spread.p_value, spread.more_m, spread.middle_m), inexact_m.max(as_built.levene_m)),
            (seen(FitTest::LackOfFit, bias.p_value, bias.rms_m, 0.0), inexact_m.max(as_built.lack_of_fit_m)),
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

    /// Expected law error of the members, metres, times `share`. Zero if a size is at the end of its range.
    fn allowed_law_error_m(&self, fitted: &FittedSet, share: f64) -> f64 {
        let ended = |member: &SetMember| self.candidates[member.candidate].is_at_range_end(&member.values);
        if fitted.members.iter().any(ended) { 0.0 } else { share * self.law_error_m(&fitted.simulated_m) }
    }

    /// Sensitivities to every effect that may be named, one column a size, without uncertain parameters.
    fn catalogue_sensitivities(&self) -> DMatrix<f64> {
        let open = self.fit_problem().open;
        let asked = |number: usize| open[number] && !self.options.is_uncertain(self.candidates[number].card.name);
        let own = self.sensitivities.iter().filter(|sensitivity| asked(sensitivity.candidate));
        let columns: Vec<DVectorView<f64>> = own.flat_map(|sensitivity| sensitivity.columns.column_iter()).collect();
        DMatrix::from_fn(3 * self.training.len(), columns.len(), |row, k| columns[k][row])
    }
}
