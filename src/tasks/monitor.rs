//! A monitor inside the loop: does the model still hold? A cumulative sum of the log-likelihood
//! ratio (Page 1954) between innovations as they were when it was calibrated and innovations of
//! [`INFLATION`] times that covariance.

use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use serde::{Deserialize, Serialize};

use super::TaskError;
use crate::base::{BadOption, Point3, Seed};

/// Innovations of a model that no longer holds: twice as large, four times the covariance.
const INFLATION: f64 = 4.0;
/// The threshold is this multiple of the largest sum in so many stretches of `false_alarm_s` of
/// work that is drawn from the calibration's: work to come has trials that the calibration has not
/// seen. Without the multiple, one monitor of two raised false alarms (docs/evidence/repair.md).
const THRESHOLD_MARGIN: f64 = 1.5;
const STRETCHES: usize = 30;
/// Trials with innovations that a calibration needs.
const MIN_TRIALS: usize = 20;
/// Standard deviation below which an innovation is no measurement, metres.
const MIN_DEVIATION_M: f64 = 1e-6;

/// Monitoring of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MonitorOptions {
    /// Control steps of a trial of work: 2 to 10,000.
    pub trial_steps: usize,
    /// Operating time for the calibration of the monitor, seconds.
    pub calibration_s: f64,
    /// Operating time of an unchanged robot with less than one permitted false alarm, seconds.
    pub false_alarm_s: f64,
    /// Subsequent operating time of the unchanged robot in which false alarms are counted, seconds.
    pub watched_s: f64,
    /// Operating time of a changed robot after which an alarm counts as missed, seconds.
    pub patience_s: f64,
}

impl Default for MonitorOptions {
    fn default() -> Self {
        MonitorOptions {
            trial_steps: 20,
            calibration_s: 1200.0,
            false_alarm_s: 36_000.0,
            watched_s: 36_000.0,
            patience_s: 120.0,
        }
    }
}

impl MonitorOptions {
    /// Checks every range.
    ///
    /// # Errors
    /// [`BadOption`] names the first field out of range.
    pub fn check(&self) -> Result<(), BadOption> {
        if !(2..=10_000).contains(&self.trial_steps) {
            let found = self.trial_steps.to_string();
            return Err(BadOption { key: "trial_steps", found, expected: "2 to 10000 steps" });
        }
        let ranges = [
            ("calibration_s", self.calibration_s, [60.0, 36_000.0], "60 to 36000 s"),
            ("false_alarm_s", self.false_alarm_s, [60.0, 3.6e6], "60 to 3600000 s"),
            ("watched_s", self.watched_s, [0.0, 3.6e5], "0 to 360000 s"),
            ("patience_s", self.patience_s, [1.0, 36_000.0], "1 to 36000 s"),
        ];
        let wrong =
            ranges.into_iter().find(|(_, value, [low, high], _)| !(*low..=*high).contains(value));
        wrong.map_or(Ok(()), |(key, value, _, expected)| {
            Err(BadOption { key, found: value.to_string(), expected })
        })
    }
}

/// A calibrated monitor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Monitor {
    /// Mean of the innovations, metres.
    mean_m: Point3,
    /// Inverse covariance of the innovations, 1/m².
    information: [[f64; 3]; 3],
    /// Sum above which the model no longer holds.
    threshold: f64,
}

/// A monitor at work.
pub struct MonitorState<'a> {
    monitor: &'a Monitor,
    sum: f64,
}

impl Monitor {
    /// Calibrates a monitor from the innovations of trials of the unchanged robot, metres, in steps
    /// of `step_s` seconds. Consecutive innovations are correlated, so the threshold is found by
    /// drawing whole trials (Künsch 1989).
    ///
    /// # Errors
    /// [`TaskError::TooFew`] for fewer than 20 trials with innovations.
    pub fn calibrate(
        trials: &[Vec<Point3>],
        options: &MonitorOptions,
        step_s: f64,
        seed: Seed,
    ) -> Result<Monitor, TaskError> {
        let trials: Vec<&Vec<Point3>> = trials.iter().filter(|trial| !trial.is_empty()).collect();
        if trials.len() < MIN_TRIALS {
            let what = "trials of work with measurements to calibrate the monitor";
            return Err(TaskError::TooFew { what, required: MIN_TRIALS, available: trials.len() });
        }
        let all: Vec<Vector3<f64>> =
            trials.iter().copied().flatten().map(|innovation| Vector3::from(*innovation)).collect();
        let mean = all.iter().sum::<Vector3<f64>>() / all.len() as f64;
        let scatter: Matrix3<f64> = all
            .iter()
            .map(|innovation| (innovation - mean) * (innovation - mean).transpose())
            .sum();
        // A direction without scatter would make the covariance singular.
        let noise_floor = Matrix3::identity() * MIN_DEVIATION_M * MIN_DEVIATION_M;
        let covariance = scatter / (all.len() - 1) as f64 + noise_floor;
        let information = covariance
            .try_inverse()
            .ok_or(TaskError::NotFinite("covariance of the innovations"))?;
        let mut monitor = Monitor {
            mean_m: mean.into(),
            information: information.transpose().into(),
            threshold: f64::INFINITY,
        };
        // Each ratio is computed once, for trials are drawn many times.
        let ratios: Vec<Vec<f64>> = trials
            .iter()
            .map(|trial| trial.iter().map(|innovation| monitor.log_ratio(innovation)).collect())
            .collect();
        let steps = (options.false_alarm_s / step_s).ceil() as usize * STRETCHES;
        monitor.threshold = THRESHOLD_MARGIN * largest_sum(&ratios, steps, seed);
        Ok(monitor)
    }

    /// Begins to watch.
    pub fn watch(&self) -> MonitorState<'_> {
        MonitorState { monitor: self, sum: 0.0 }
    }

    /// Sum above which the model no longer holds.
    pub fn threshold(&self) -> f64 {
        self.threshold
    }

    /// ln p(ν; inflated) − ln p(ν; calibrated) of normal innovations.
    fn log_ratio(&self, innovation_m: &Point3) -> f64 {
        let deviation = Vector3::from(*innovation_m) - Vector3::from(self.mean_m);
        let mahalanobis_squared = (Matrix3::from(self.information) * deviation).dot(&deviation);
        // Normal densities with covariances Σ and cΣ: ½ (d² (1 − 1/c) − 3 ln c).
        0.5 * (mahalanobis_squared * (1.0 - 1.0 / INFLATION) - 3.0 * INFLATION.ln())
    }
}

impl MonitorState<'_> {
    /// Takes the innovation of a step, metres. True when the model no longer holds; the sum then
    /// begins anew.
    pub fn alarms(&mut self, innovation_m: &Point3) -> bool {
        // Page's sum: it never falls below zero, so that work before a change does not delay the
        // alarm.
        self.sum = (self.sum + self.monitor.log_ratio(innovation_m)).max(0.0);
        let alarm = self.sum > self.monitor.threshold;
        if alarm {
            self.sum = 0.0;
        }
        alarm
    }
}

/// The largest cumulative sum in so many steps of trials that are drawn with replacement.
fn largest_sum(ratios: &[Vec<f64>], steps: usize, seed: Seed) -> f64 {
    let mut random = seed.child("monitor").rng();
    let (mut sum, mut largest, mut drawn_steps) = (0.0_f64, 0.0_f64, 0);
    while drawn_steps < steps {
        let trial = &ratios[random.random_range(0..ratios.len())];
        // The sum goes on across trials, as it does at work.
        for ratio in trial {
            sum = (sum + ratio).max(0.0);
            largest = largest.max(sum);
        }
        drawn_steps += trial.len();
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};

    /// Trials of 20 innovations that share a part within a trial, as a model's error does.
    fn trials(count: usize, shift_m: f64, seed: u64) -> Vec<Vec<Point3>> {
        let mut random = Seed(seed).rng();
        let mut normal = |deviation: f64| -> f64 {
            let drawn: f64 = StandardNormal.sample(&mut random);
            deviation * drawn
        };
        let mut trial = || {
            let common: Point3 = std::array::from_fn(|_| normal(8e-4));
            (0..20)
                .map(|_| std::array::from_fn(|axis| common[axis] + shift_m + normal(5e-4)))
                .collect()
        };
        (0..count).map(|_| trial()).collect()
    }

    #[test]
    fn a_change_is_told_in_seconds_and_ten_hours_without_one_are_quiet() {
        let options = MonitorOptions::default();
        let monitor = Monitor::calibrate(&trials(300, 0.0, 1), &options, 0.2, Seed(1)).unwrap();
        let mut state = monitor.watch();
        let false_alarms = trials(9000, 0.0, 2)
            .iter()
            .flatten()
            .filter(|innovation_m| state.alarms(innovation_m))
            .count();
        assert_eq!(false_alarms, 0, "in ten hours");
        let mut state = monitor.watch();
        let steps = trials(10, 0.004, 3)
            .iter()
            .flatten()
            .position(|innovation_m| state.alarms(innovation_m))
            .unwrap();
        assert!(steps < 15, "{steps} steps");
    }

    #[test]
    fn too_little_work_is_refused() {
        let few = Monitor::calibrate(&trials(19, 0.0, 1), &MonitorOptions::default(), 0.2, Seed(1));
        assert!(matches!(few, Err(TaskError::TooFew { available: 19, .. })));
    }
}
