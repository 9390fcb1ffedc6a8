//! What a goodness-of-fit test is called and what it reports.

/// Test by which a set is rejected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FitTest {
    /// Cross-trial test: other trials predict the residual.
    CrossTrial,
    /// Variance above the noise floor.
    Variance,
    /// Small excess variance of a slowly changing residual.
    SlowVariance,
    /// Levene's test: unequal scatter over the trials.
    Levene,
    /// Lack of fit: biased means of repeated measurements.
    LackOfFit,
    /// Spearman test: the residual grows with the displacement.
    Spearman,
    /// Score test: all effects together explain part of the residual.
    Score,
    /// Variance on held-out trials above that on training trials.
    HeldOut,
}

/// Result of a test.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TestResult {
    pub(crate) test: FitTest,
    /// Probability of this or more from noise.
    pub(crate) p_value: f64,
    /// Size of the detected part of the residual, rms, metres.
    pub(crate) more_m: f64,
    /// Reference size, rms, metres, if two variances are compared (squares add up); else zero.
    pub(crate) beyond_m: f64,
}

impl TestResult {
    /// Whether the test fails: the p-value is below `significance` and the size above `min_m`.
    pub(crate) fn is_failed(&self, significance: f64, min_m: f64) -> bool {
        self.p_value < significance && self.more_m > min_m
    }
}
