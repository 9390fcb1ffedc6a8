//! What the tests find in the baseline, where nothing is missing: as much in the measured recording is no discovery.

use nalgebra::DVector;

use super::lack_of_fit::lack_of_fit_test;
use super::levene::levene_test;
use crate::discovery::fit::ar1_noise::Ar1Noise;
use crate::discovery::fit::nuisance::NuisanceFit;
use crate::discovery::noise_floor::NoiseFloor;
use crate::discovery::problem::{Baseline, Problem};

/// Significance level at which a test finds something in the baseline.
const SIGNIFICANT: f64 = 0.01;

/// Sizes that tests find in the baseline with the margin of the options, metres; zero where they find nothing, and
/// without a baseline.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct BaselineSizes {
    pub(crate) levene_m: f64,
    pub(crate) lack_of_fit_m: f64,
}

impl BaselineSizes {
    pub(crate) fn new(problem: &Problem) -> BaselineSizes {
        problem.base.as_ref().map_or_else(BaselineSizes::default, |base| of(base, problem.options.form_margin))
    }
}

fn of(base: &Baseline, margin: f64) -> BaselineSizes {
    let noise = Ar1Noise::estimate(&base.samples, &base.form.unseen_m, 0.0);
    let unseen =
        NuisanceFit { noise, amounts: DVector::zeros(0), residual_m: base.form.unseen_m.clone(), deviance: f64::NAN };
    let floor = NoiseFloor::estimate(&base.samples, &unseen, &base.simulated_m);
    let spread = levene_test(&base.samples, &unseen);
    let bias = lack_of_fit_test(&base.samples, &base.form.unseen_m, &noise, &floor);
    let size_m = |p_value: f64, size_m: f64| if p_value < SIGNIFICANT { margin * size_m } else { 0.0 };
    BaselineSizes { levene_m: size_m(spread.p_value, spread.more_m), lack_of_fit_m: size_m(bias.p_value, bias.rms_m) }
}
