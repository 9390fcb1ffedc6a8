//! Whether a set of effects leaves more of the samples than nuisances and noise: six tests, each of which sees what others
//! miss.

pub(crate) mod cross_trial;
pub(crate) mod kernel_ridge;
pub(crate) mod levene;
pub(crate) mod score_test;
pub(crate) mod spearman;

use nalgebra::{DMatrix, DVectorView};

use super::fit::candidate::Member;
use super::fit::gauss_newton::Fitted;
use super::fit::nuisance::{Explained, Nuisances};
use super::noise_floor::{Floor, bias};
use super::problem::Question;
use super::recording::covariates::circumstances;
use cross_trial::{Missing, missing};
use score_test::together;
use spearman::grows;

/// By what it shows that a set is not all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Test {
    /// What it leaves is foretold by other trials.
    Foretold,
    /// It leaves more scatter than the noise floor.
    Scatter,
    /// The same, by little, but of what hardly changes from one sample to the next.
    Slow,
    /// It leaves more in some trials than in others.
    Uneven,
    /// Its mean is off where the same thing was measured again.
    Bias,
    /// It leaves more where it does more.
    Grows,
    /// A little of every effect together explains more of what it leaves than of noise.
    Together,
    /// Trials that took no part in its fit scatter more about it than those of the fit.
    HeldOut,
}

/// What a test found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sign {
    pub(crate) test: Test,
    /// Chance of as much from noise.
    pub(crate) p_value: f64,
    /// How much of the residual it is about, root mean square, metres, …
    pub(crate) more_m: f64,
    /// … beyond this much, where two scatters are compared (the squares add up).
    pub(crate) beyond_m: f64,
}

/// Whether something is left.
#[derive(Clone, Debug)]
pub(crate) struct Left {
    /// The clearest sign of it, by a chance below `false_alarm`, or that it is slower than any noise.
    pub(crate) sign: Option<Sign>,
    /// By one that is worth a longer search.
    pub(crate) possibly: bool,
    /// What all effects together would certainly explain of it, but no more than laws may be off by, metres.
    pub(crate) tolerated_m: Option<f64>,
    /// The noise floor that it was held against.
    pub(crate) floor: Floor,
}

/// Correlation from one sample to the next beyond which what is left is not a tracker's noise.
const SLOW: f64 = 0.8;
/// Chance below which such a residual is more than the repeats' noise.
const SLOW_CHANCE: f64 = 0.05;
/// Chance of any test below which the search goes on before it says that nothing is missing.
const DOUBTFUL: f64 = 0.05;
/// Laws of how a rod gives way stand for many; effects without a shape or a place are off by this share of `least_share`.
const WITHOUT_SHAPE: f64 = 0.5;

impl Left {
    /// Whether it is more than noise leaves.
    pub(crate) fn certainly(&self) -> bool {
        self.sign.is_some()
    }
}

impl Question<'_> {
    /// Whether what is left of the samples of the fit can be foretold.
    pub(crate) fn foretold(&self, explained: &Explained, played: &[f64]) -> Missing {
        let around = circumstances(&self.fit, played);
        missing(&self.fit, &around, &explained.left_m, self.options.seed())
    }

    /// Whether `fitted` leaves more than the `nuisances` beside it and noise; `foretold`: what can be foretold of it.
    pub(crate) fn left(&self, nuisances: &Nuisances, fitted: &Fitted, foretold: &Missing) -> Left {
        let explained = &fitted.explained;
        let floor_m = explained.noise.rms_m();
        let model_m = self.options.least_m(&self.model);
        let least_m = self.least_left_m(floor_m);
        let inexact_m = least_m.max(self.laws_m(fitted, 1.0));
        // More scatter than noise alone; scatter that hardly changes from one sample to the next is no tracker's, and little
        // more of it is enough.
        let floor = Floor::of(&self.fit, explained, &fitted.played);
        let scatters = floor.chance_of(&Floor::left_by(explained, &self.fit));
        let alone_m = floor.rms_m();
        let more_m = (floor_m.powi(2) - alone_m.powi(2)).max(0.0).sqrt();
        let slow = explained.noise.correlation > SLOW && scatters < SLOW_CHANCE && more_m > model_m;
        let spread = levene::uneven(&self.fit, explained);
        let bias = bias(&self.fit, &explained.left_m, &explained.noise, &floor);
        let grows = grows(explained, &self.moved(&fitted.played));
        let all = together(&self.fit, nuisances, fitted, &self.answers());
        let (all, all_m) = all.map_or((1.0, 0.0), |found| (found.p_value, found.more_m));
        // That is only the part of what is left that the catalogue reaches, and not held against the noise floor.
        let shaped = fitted.members.iter().any(|member| self.hypotheses[member.hypothesis].has_shape());
        let tolerable_m = model_m.max(self.laws_m(fitted, if shaped { 1.0 } else { WITHOUT_SHAPE }));
        let seen = |test, p_value, more_m, beyond_m| Sign { test, p_value, more_m, beyond_m };
        // What each test found, and how large it must be to matter.
        let tests = [
            (seen(Test::Foretold, foretold.test.p_value, foretold.test.foretold_m, 0.0), least_m),
            (seen(Test::Scatter, scatters, more_m, alone_m), least_m),
            (seen(Test::Uneven, spread.p_value, spread.more_m, spread.middle_m), inexact_m),
            (seen(Test::Bias, bias.p_value, bias.rms_m, 0.0), inexact_m),
            (seen(Test::Together, all, all_m, 0.0), tolerable_m),
            (seen(Test::Grows, grows.p_value, grows.more_m, grows.least_m), inexact_m),
        ];
        let below = |chance: f64| {
            let clear = tests.iter().filter(|(sign, matters_m)| sign.more_m > *matters_m && sign.p_value < chance);
            clear.map(|(sign, _)| *sign).min_by(|a, b| a.p_value.total_cmp(&b.p_value))
        };
        let sign = below(self.options.false_alarm).or(slow.then(|| seen(Test::Slow, scatters, more_m, alone_m)));
        let possibly = sign.or(below(DOUBTFUL / tests.len() as f64)).is_some();
        let is_tolerated = all < self.options.false_alarm && all_m > model_m && all_m <= tolerable_m;
        Left { sign, possibly, tolerated_m: is_tolerated.then_some(all_m), floor }
    }

    /// What the laws of the members may be off by, metres: this `share` of what laws are off by at their best. Nothing where
    /// a size would go on beyond the end of its range: that is no law's error.
    fn laws_m(&self, fitted: &Fitted, share: f64) -> f64 {
        let ended = |member: &Member| self.hypotheses[member.hypothesis].is_at_an_end(&member.values);
        if fitted.members.iter().any(ended) { 0.0 } else { share * self.inexact_m(&fitted.played) }
    }

    /// How the tip answers to a little of every effect that could be the answer, a column a size. Not of those that are
    /// uncertain: together they would tell how uncertain, which is the lab's to say.
    fn answers(&self) -> DMatrix<f64> {
        let open = self.study().open;
        let asked = |number: usize| open[number] && !self.options.is_uncertain(&self.hypotheses[number]);
        let own = self.responses.iter().filter(|response| asked(response.hypothesis));
        let columns: Vec<DVectorView<f64>> = own.flat_map(|response| response.columns.column_iter()).collect();
        DMatrix::from_fn(3 * self.fit.len(), columns.len(), |row, k| columns[k][row])
    }
}
