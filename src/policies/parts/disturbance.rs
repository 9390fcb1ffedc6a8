//! The constant by which the robot differs from its model here and now, estimated from
//! measurements: what makes a control that predicts free of offset (Muske & Badgwell 2002;
//! Pannocchia & Rawlings 2003). A Kalman filter with one variance for all three axes.

use serde::{Deserialize, Serialize};

use crate::base::{BadOption, Point3};

/// How the disturbance is estimated. Standard deviations are those of one axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DisturbanceOptions {
    /// Standard deviation of the tracking noise.
    pub noise_m: f64,
    /// Standard deviation of the disturbance before the first measurement.
    pub first_sd_m: f64,
    /// Change of the disturbance in a tick at rest.
    pub drift_m: f64,
    /// Change of the disturbance for each metre that the expected tip moves, metres.
    pub drift_per_motion: f64,
    /// Error of a measurement for each metre that the expected tip moves in the tick, metres: the
    /// robot may not be at rest yet.
    pub lag_per_motion: f64,
}

impl Default for DisturbanceOptions {
    fn default() -> Self {
        DisturbanceOptions {
            noise_m: 0.0005,
            first_sd_m: 0.003,
            drift_m: 0.00015,
            drift_per_motion: 0.3,
            lag_per_motion: 0.05,
        }
    }
}

impl DisturbanceOptions {
    pub(crate) fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("noise_m", self.noise_m)?;
        BadOption::unless_not_negative("first_sd_m", self.first_sd_m)?;
        BadOption::unless_not_negative("drift_m", self.drift_m)?;
        BadOption::unless_not_negative("drift_per_motion", self.drift_per_motion)?;
        BadOption::unless_not_negative("lag_per_motion", self.lag_per_motion)
    }
}

/// The estimate.
pub(crate) struct DisturbanceFilter {
    options: DisturbanceOptions,
    /// Largest share of what a measurement adds.
    max_gain: f64,
    /// Measured less expected tip, metres.
    pub(crate) offset_m: Point3,
    variance_m2: f64,
}

impl DisturbanceFilter {
    pub(crate) fn new(options: DisturbanceOptions) -> DisturbanceFilter {
        DisturbanceFilter {
            options,
            max_gain: 1.0,
            offset_m: [0.0; 3],
            variance_m2: options.first_sd_m.powi(2),
        }
    }

    /// The same that takes no measurement for more than this share: what a swinging robot differs
    /// from the swing of its model is no disturbance.
    #[must_use]
    pub(crate) fn with_max_gain(self, max_gain: f64) -> DisturbanceFilter {
        DisturbanceFilter { max_gain, ..self }
    }

    pub(crate) fn reset(&mut self) {
        *self = DisturbanceFilter::new(self.options).with_max_gain(self.max_gain);
    }

    /// Standard deviation of the estimate on an axis, metres.
    pub(crate) fn sd_m(&self) -> f64 {
        self.variance_m2.sqrt()
    }

    /// A measurement, where the expected tip has moved by `moved_m` since the last one.
    pub(crate) fn measured(&mut self, tip_m: &Point3, expected_m: &Point3, moved_m: f64) {
        let options = &self.options;
        // Prediction: the disturbance drifts, the more the farther the robot moves.
        self.variance_m2 += options.drift_m.powi(2) + (options.drift_per_motion * moved_m).powi(2);
        let noise_m2 = options.noise_m.powi(2) + (options.lag_per_motion * moved_m).powi(2);
        // Correction: gain P / (P + R), then P ← (1 − gain) P.
        let best_gain = self.variance_m2 / (self.variance_m2 + noise_m2);
        let gain = best_gain.min(self.max_gain);
        for (axis, offset_m) in self.offset_m.iter_mut().enumerate() {
            *offset_m += gain * (tip_m[axis] - expected_m[axis] - *offset_m);
        }
        if gain == best_gain {
            self.variance_m2 *= 1.0 - gain;
        } else {
            // Of a smaller gain P ← (1 − gain)² P + gain² R.
            self.variance_m2 = (1.0 - gain).powi(2) * self.variance_m2 + gain.powi(2) * noise_m2;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_largest_gain_holds_and_the_estimate_stays_less_sure() {
        let options = DisturbanceOptions::default();
        let [mut free, mut bounded] =
            [1.0, 0.2].map(|gain| DisturbanceFilter::new(options).with_max_gain(gain));
        for disturbance in [&mut free, &mut bounded] {
            disturbance.measured(&[0.01, 0.0, 0.2], &[0.0, 0.0, 0.2], 0.05);
        }
        assert!((bounded.offset_m[0] - 0.002).abs() < 1e-12 && free.offset_m[0] > 0.009);
        assert!(bounded.sd_m() > free.sd_m());
    }

    #[test]
    fn at_rest_the_estimate_is_nearly_the_mean_of_what_was_measured() {
        let options =
            DisturbanceOptions { drift_m: 0.0, first_sd_m: 1.0, ..DisturbanceOptions::default() };
        let mut disturbance = DisturbanceFilter::new(options);
        for tick in 0..10 {
            let tip_m = [0.001 * f64::from(tick), 0.0, 0.2];
            disturbance.measured(&tip_m, &[0.0, 0.0, 0.2], 0.0);
        }
        assert!((disturbance.offset_m[0] - 0.0045).abs() < 1e-6, "{:?}", disturbance.offset_m);
        assert!(
            (disturbance.sd_m() - 0.0005 / 10.0_f64.sqrt()).abs() < 1e-7,
            "{}",
            disturbance.sd_m()
        );
    }
}
