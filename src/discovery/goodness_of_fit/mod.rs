//! Goodness of fit: are the residuals of a fitted set noise? Six tests, one file each; `held_out`
//! adds a seventh on held-out trials.

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
    /// Significant residual that all effects together explain, but within the expected law errors,
    /// metres.
    pub(crate) tolerated_m: Option<f64>,
    /// The noise floor of the tests.
    pub(crate) floor: NoiseFloor,
}

/// Correlation above which a residual is no tracker noise, and significance level of the variance
/// test for such a residual. This and the constants below are those of docs/method/search.md, "Is
/// anything missing?".
const MAX_TRACKER_CORRELATION: f64 = 0.8;
const SLOW_SIGNIFICANCE: f64 = 0.05;
/// Significance level below which the search goes on.
const DOUBTFUL_SIGNIFICANCE: f64 = 0.05;
/// Share of the expected law error for effects without shape or choice parameters, whose laws are
/// more accurate.
const WITHOUT_SHAPE: f64 = 0.5;

impl Problem<'_> {
    /// Cross-trial test of the training residual.
    pub(crate) fn cross_trial_test(
        &self,
        nuisance_fit: &NuisanceFit,
        simulated_m: &[f64],
    ) -> CrossTrialTest {
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
        let (samples, nuisance_fit) = (&self.training, &fitted.nuisance_fit);
        let model_m = self.model_error_m();
        let relevant_m = self.least_relevant_m(nuisance_fit.noise.rms_m());
        // Effects that were found may follow laws a little different from the catalogue's.
        let law_m = relevant_m.max(self.allowed_law_error_m(fitted, 1.0));
        // Test 2: variance above the noise floor.
        let floor = NoiseFloor::estimate(samples, nuisance_fit, &fitted.simulated_m);
        let [residual_m, floor_m] = [nuisance_fit.noise.rms_m(), floor.rms_m()];
        let variance = TestResult {
            test: FitTest::Variance,
            p_value: floor.p_value_of(&NoiseFloor::of_residual(nuisance_fit, samples)),
            more_m: (residual_m.powi(2) - floor_m.powi(2)).max(0.0).sqrt(),
            beyond_m: floor_m,
        };
        let cross_trial = TestResult {
            test: FitTest::CrossTrial,
            p_value: foretold.test.p_value,
            more_m: foretold.test.foretold_m,
            beyond_m: 0.0,
        };
        let lack_of_fit =
            lack_of_fit_test(samples, &nuisance_fit.residual_m, &nuisance_fit.noise, &floor);
        let spearman = spearman_test(nuisance_fit, &self.displacement_m(&fitted.simulated_m));
        // With too few samples the score test is not asked.
        let nothing = TestResult { test: FitTest::Score, p_value: 1.0, more_m: 0.0, beyond_m: 0.0 };
        let score = score_test(samples, nuisances, fitted, &self.catalogue_sensitivities())
            .unwrap_or(nothing);
        // The score test covers only the part that the catalogue explains, and is not relative to
        // the noise floor.
        let has_shape =
            fitted.members.iter().any(|member| self.candidates[member.candidate].has_shape());
        let tolerable_m = model_m
            .max(self.allowed_law_error_m(fitted, if has_shape { 1.0 } else { WITHOUT_SHAPE }));
        // A robot that the model does not describe exactly does not follow the laws of its effects
        // exactly either.
        let predictable_m = if self.model_form_m > 0.0 { law_m } else { relevant_m };
        let as_built = BaselineSizes::new(self);
        // Each test with its minimum relevant size.
        let tests = [
            (cross_trial, predictable_m),
            (variance, predictable_m),
            (levene_test(samples, nuisance_fit), law_m.max(as_built.levene_m)),
            (lack_of_fit, law_m.max(as_built.lack_of_fit_m)),
            (score, tolerable_m),
            (spearman, law_m),
        ];
        let worst_below = |significance: f64| {
            let failed =
                tests.iter().filter(|(result, min_m)| result.is_failed(significance, *min_m));
            failed.map(|(result, _)| *result).min_by(|a, b| a.p_value.total_cmp(&b.p_value))
        };
        // Little excess variance suffices if the residual is too slow for tracker noise.
        let is_slow = nuisance_fit.noise.correlation > MAX_TRACKER_CORRELATION
            && variance.is_failed(SLOW_SIGNIFICANCE, model_m);
        let slow_variance =
            is_slow.then_some(TestResult { test: FitTest::SlowVariance, ..variance });
        let failed = worst_below(self.options.false_alarm).or(slow_variance);
        // Bonferroni's correction: the search goes on if any of the tests is doubtful.
        let is_doubtful =
            failed.or(worst_below(DOUBTFUL_SIGNIFICANCE / tests.len() as f64)).is_some();
        let is_tolerated =
            score.is_failed(self.options.false_alarm, model_m) && score.more_m <= tolerable_m;
        GoodnessOfFit {
            failed,
            is_doubtful,
            tolerated_m: is_tolerated.then_some(score.more_m),
            floor,
        }
    }

    /// Expected law error of the members, metres, times `share`. Zero if a size is at the end of
    /// its range.
    fn allowed_law_error_m(&self, fitted: &FittedSet, share: f64) -> f64 {
        let is_at_end =
            |member: &SetMember| self.candidates[member.candidate].is_at_range_end(&member.values);
        if fitted.members.iter().any(is_at_end) {
            0.0
        } else {
            share * self.law_error_m(&fitted.simulated_m)
        }
    }

    /// Sensitivities to every effect that may be named, one column a size, without uncertain
    /// parameters.
    fn catalogue_sensitivities(&self) -> DMatrix<f64> {
        let open = self.fit_problem().open;
        let is_named = |candidate: usize| {
            open[candidate] && !self.options.is_uncertain(self.candidates[candidate].card.name)
        };
        let named = self.sensitivities.iter().filter(|sensitivity| is_named(sensitivity.candidate));
        let columns: Vec<DVectorView<f64>> =
            named.flat_map(|sensitivity| sensitivity.columns.column_iter()).collect();
        DMatrix::from_fn(3 * self.training.len(), columns.len(), |row, k| columns[k][row])
    }
}
