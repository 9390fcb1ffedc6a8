//! The length of the time steps.

use crate::rod::params::scheme::Tableau;

/// The length of the time steps.
#[derive(Clone, Debug)]
pub(crate) struct StepSize {
    /// Suggested length of the next step from the error of the last one, s; infinite before the
    /// first.
    pub(crate) next_s: f64,
    /// Time that was asked for and was too short for a step, s: it is added to the next motion.
    pub(crate) owed_s: f64,
    /// Whether deviations grow, and the rod has one.
    pub(crate) deviates: bool,
    /// Longest step that growing oscillations allow, s, and the steps for which it holds.
    pub(crate) flutter: Option<FlutterLimit>,
    /// Steps since the rod was made or restarted.
    pub(crate) steps: u64,
    /// Time of each stage as a share of the step.
    pub(crate) stage_times: Vec<f64>,
}

/// What oscillations that grow under follower loads allow.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FlutterLimit {
    /// Longest step, s.
    pub(crate) longest_s: f64,
    /// Steps until it is computed again.
    pub(crate) remaining_steps: u32,
}

impl StepSize {
    pub(crate) fn new(tableau: &Tableau) -> StepSize {
        let stage_times: Vec<f64> = tableau.rows.iter().map(|row| row.iter().sum()).collect();
        StepSize {
            next_s: f64::INFINITY,
            owed_s: 0.0,
            deviates: false,
            flutter: None,
            steps: 0,
            stage_times,
        }
    }
}
