//! What a trial has commanded and measured.

use crate::base::Point3;
use crate::hardware::axes::AXES;

/// A command of a trial and the tip after it.
#[derive(Clone, Copy, Debug)]
pub(super) struct LoggedStep {
    /// Displacements, metres.
    pub(super) pulls_m: [f64; AXES],
    /// Tip position that the model predicts, metres.
    pub(super) predicted_m: Point3,
    /// Measured tip position, metres; none without tracking.
    pub(super) measured_m: Option<Point3>,
}

/// The present trial.
#[derive(Clone, Debug, Default)]
pub(super) struct TrialLog {
    /// Predicted and measured tip position at its start, metres.
    pub(super) home_m: Point3,
    pub(super) measured_home_m: Option<Point3>,
    pub(super) steps: Vec<LoggedStep>,
}

impl TrialLog {
    /// Distance between the smallest and the largest displacement of an axis, home included, metres.
    pub(super) fn span_m(&self, axis: usize) -> f64 {
        let pulls_m = self.steps.iter().map(|step| step.pulls_m[axis]);
        let (low_m, high_m) = pulls_m.fold((0.0_f64, 0.0_f64), |(low_m, high_m), pull_m| {
            (low_m.min(pull_m), high_m.max(pull_m))
        });
        high_m - low_m
    }
}
