//! What the tests find in the baseline, where nothing is missing: as much in the measured recording
//! is no discovery.

use nalgebra::DVector;

use super::lack_of_fit::lack_of_fit_test;
use super::levene::levene_test;
use super::test_result::TestResult;
use crate::discovery::fit::ar1_noise::Ar1Noise;
use crate::discovery::fit::nuisance::NuisanceFit;
use crate::discovery::noise_floor::NoiseFloor;
use crate::discovery::problem::Problem;

/// Significance level at which a test finds something in the baseline.
const SIGNIFICANCE: f64 = 0.01;

/// Sizes that tests find in the baseline with the margin of the options, metres; zero where they
/// find nothing, and without a baseline.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct BaselineSizes {
    pub(crate) levene_m: f64,
    pub(crate) lack_of_fit_m: f64,
}

impl BaselineSizes {
    pub(crate) fn new(problem: &Problem) -> BaselineSizes {
        let Some(base) = &problem.base else { return BaselineSizes::default() };
        let (samples, residual_m) = (&base.samples, base.form.unseen_m.clone());
        // Each trial was corrected by the others, so no degree of freedom was spent on it.
        let noise = Ar1Noise::estimate(samples, &residual_m, 0.0);
        let unseen =
            NuisanceFit { noise, amounts: DVector::zeros(0), residual_m, deviance: f64::NAN };
        let floor = NoiseFloor::estimate(samples, &unseen, &base.simulated_m);
        let size_m = |result: TestResult| {
            if result.p_value < SIGNIFICANCE {
                problem.options.form_margin * result.more_m
            } else {
                0.0
            }
        };
        BaselineSizes {
            levene_m: size_m(levene_test(samples, &unseen)),
            lack_of_fit_m: size_m(lack_of_fit_test(samples, &unseen.residual_m, &noise, &floor)),
        }
    }
}
