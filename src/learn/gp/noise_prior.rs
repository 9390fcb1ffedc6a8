//! What is known of the noise before a fit.
//!
//! What a process cannot follow is the measurement noise σ_0 and, independent of it, what varies
//! below the length-scales: σ_n² = σ_0² + σ_e². Nothing is known of σ_e, so ln σ_n has a flat prior
//! above ln σ_0, the one of a scale (Jeffreys 1946). Below ln σ_0 it falls as a normal density does
//! whose standard deviation is that of ln σ_0. The hyper-parameters then maximise the posterior
//! density (Rasmussen & Williams 2006, section 5.2) in place of the likelihood.

use serde::{Deserialize, Serialize};

use crate::learn::LearnError;

/// A prior for the noise of a Gaussian process: the fitted noise is at least about the measurement
/// noise. Above it only the likelihood counts, because variation that the process cannot represent
/// adds to the noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct NoisePrior {
    /// Standard deviation of the measurement noise, in the outputs' unit: metres in an experiment.
    /// `null` in an experiment: that of `plant`, and of `model` where the simulated tip is its own;
    /// without any, as of hardware, there is no prior.
    pub std_m: Option<f64>,
    /// Uncertainty: standard deviation of its logarithm. n repetitions determine it to 1/√(2(n−1));
    /// the default, 0.25, corresponds to nine.
    pub relative_std: f64,
}

impl Default for NoisePrior {
    fn default() -> Self {
        NoisePrior { std_m: None, relative_std: 0.25 }
    }
}

impl NoisePrior {
    /// Checks the ranges.
    pub(super) fn check(&self) -> Result<(), LearnError> {
        let std = self.std_m.unwrap_or(0.0);
        let (std_key, width_key) = ("noise_prior.std_m", "noise_prior.relative_std");
        LearnError::unless_setting(std >= 0.0 && std.is_finite(), std_key, std, "0 or more")?;
        let width = self.relative_std;
        LearnError::unless_setting((0.01..=10.0).contains(&width), width_key, width, "0.01 to 10")
    }

    /// For an output whose values were divided by `scale`; `None` where no noise is known.
    pub(super) fn standardised(&self, scale: f64) -> Option<NoisePenalty> {
        let std = self.std_m.filter(|std| *std > 0.0)?;
        Some(NoisePenalty {
            log_variance: 2.0 * (std / scale).ln(),
            deviation: 2.0 * self.relative_std,
        })
    }
}

/// Minus the logarithm of the prior density of the noise of one standardised output, up to a
/// constant, as a function of `ln σ_n²`.
#[derive(Clone, Copy, Debug)]
pub(super) struct NoisePenalty {
    /// `ln σ_0²`.
    log_variance: f64,
    /// Standard deviation of `ln σ_0²`.
    deviation: f64,
}

impl NoisePenalty {
    /// How far below the known noise, in standard deviations; 0 above.
    fn deviations_below(self, log_variance: f64) -> f64 {
        ((self.log_variance - log_variance) / self.deviation).max(0.0)
    }

    /// Value in nats.
    pub(super) fn value(self, log_variance: f64) -> f64 {
        0.5 * self.deviations_below(log_variance).powi(2)
    }

    /// First derivative.
    pub(super) fn slope(self, log_variance: f64) -> f64 {
        -self.deviations_below(log_variance) / self.deviation
    }

    /// Second derivative.
    pub(super) fn curvature(self, log_variance: f64) -> f64 {
        if log_variance < self.log_variance { self.deviation.powi(-2) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_falls_as_a_normal_density_below_the_known_noise_and_is_flat_above() {
        let prior = NoisePrior { std_m: Some(5e-4), relative_std: 0.25 };
        let penalty = prior.standardised(2e-3).unwrap();
        let at = |std: f64| 2.0 * (std / 2e-3).ln();
        assert_eq!(penalty.value(at(5e-3)), 0.0);
        // Two standard deviations of ln σ below.
        let below = at(5e-4 * (-0.5_f64).exp());
        assert!((penalty.value(below) - 2.0).abs() < 1e-9, "{}", penalty.value(below));
        let step = 1e-5;
        let slope = (penalty.value(below + step) - penalty.value(below - step)) / (2.0 * step);
        assert!((penalty.slope(below) - slope).abs() < 1e-6, "{slope}");
        let curvature = (penalty.slope(below + step) - penalty.slope(below - step)) / (2.0 * step);
        assert!((penalty.curvature(below) - curvature).abs() < 1e-6, "{curvature}");
        assert!(NoisePrior { std_m: Some(0.0), ..prior }.standardised(1.0).is_none());
        assert!(NoisePrior::default().standardised(1.0).is_none());
    }
}
