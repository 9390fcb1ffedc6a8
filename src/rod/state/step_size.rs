//! The length of the time steps.

use crate::rod::params::scheme::Tableau;

/// The length of the time steps.
#[derive(Clone, Debug)]
pub(crate) struct StepSize {
    /// Suggested length of the next step from the error of the last one, s; infinite before the first.
    pub(crate) next_s: f64,
    /// Whether deviations grow, and the rod has one.
    pub(crate) deviates: bool,
    /// Steps since the rod was made or restarted.
    pub(crate) taken: u64,
    /// Time of each stage as a share of the step.
    pub(crate) stage_times: Vec<f64>,
}

impl StepSize {
    pub(crate) fn new(tableau: &Tableau) -> StepSize {
        let stage_times: Vec<f64> = tableau.rows.iter().map(|row| row.iter().sum()).collect();
        StepSize { next_s: f64::INFINITY, deviates: false, taken: 0, stage_times }
    }
}
