//! Hyper-parameters at an end of the range of their search: the data alone would have gone on.

use super::Gp;

/// A hyper-parameter within this factor of an end is at it: where the likelihood hardly slopes, a
/// search ends before it has reached the end.
const END_FACTOR: f64 = 2.0;

/// A hyper-parameter at an end of its range.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RangeEnd {
    /// Output, from 0.
    pub output: usize,
    /// Name of the hyper-parameter.
    pub name: String,
    /// The upper end: of a length-scale that of an input without influence. Else the lower one: of
    /// the noise variance the square of `noise_floor`.
    pub is_upper: bool,
}

impl RangeEnd {
    /// `noise variance low`.
    pub fn describe(&self) -> String {
        format!("{} {}", self.name, if self.is_upper { "high" } else { "low" })
    }
}

impl Gp {
    /// The hyper-parameters at an end of their range, output by output.
    pub fn range_ends(&self) -> Vec<RangeEnd> {
        let parameters = self.covariance.hyperparameters(self.config.noise_floor);
        let mut found = Vec::new();
        for (output, theta) in self.theta.iter().enumerate() {
            for (parameter, ln_value) in parameters.iter().zip(theta) {
                let (low, high) = parameter.bounds;
                let is_upper = *ln_value >= (high / END_FACTOR).ln();
                if is_upper || *ln_value <= (low * END_FACTOR).ln() {
                    found.push(RangeEnd { output, name: parameter.name.clone(), is_upper });
                }
            }
        }
        found
    }
}
