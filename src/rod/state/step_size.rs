//! The length of the time steps.

use crate::rod::params::scheme::Tableau;

/// The length of the time steps.
#[derive(Clone, Debug)]
pub(crate) struct Pace {
    /// What the error of the last step suggests for the next one, s; infinite before the first.
    pub(crate) next_s: f64,
    /// Steps since the rod was made or restarted.
    pub(crate) taken: u64,
    /// Time of each stage as a share of the step.
    pub(crate) stage_times: Vec<f64>,
}

impl Pace {
    pub(crate) fn new(tableau: &Tableau) -> Pace {
        let stage_times: Vec<f64> = tableau.rows.iter().map(|row| row.iter().sum()).collect();
        Pace { next_s: f64::INFINITY, taken: 0, stage_times }
    }
}
