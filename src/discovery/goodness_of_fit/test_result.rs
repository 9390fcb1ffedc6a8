//! What a goodness-of-fit test is called and what it reports.

/// By what it shows that a set is not all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FitTest {
    /// What it leaves is foretold by other trials.
    CrossTrial,
    /// It leaves more scatter than the noise floor.
    Variance,
    /// The same, by little, but of what hardly changes from one sample to the next.
    SlowVariance,
    /// It leaves more in some trials than in others.
    Levene,
    /// Its mean is off where the same thing was measured again.
    LackOfFit,
    /// It leaves more where it does more.
    Spearman,
    /// A little of every effect together explains more of what it leaves than of noise.
    Score,
    /// Trials that took no part in its fit scatter more about it than those of the fit.
    HeldOut,
}

/// What a test found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TestResult {
    pub(crate) test: FitTest,
    /// Chance of as much from noise.
    pub(crate) p_value: f64,
    /// How much of the residual it is about, root mean square, metres, …
    pub(crate) more_m: f64,
    /// … beyond this much, where two scatters are compared (the squares add up).
    pub(crate) beyond_m: f64,
}
