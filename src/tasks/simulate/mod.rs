//! A recording simulated by a model.

pub(super) mod robot_recordings;
pub(super) mod simulate_recording;
pub(super) mod simulated_columns;
pub(super) mod simulated_trial;
