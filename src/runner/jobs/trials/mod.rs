//! Trials of one policy.

pub(crate) mod reach_track;
pub(crate) mod responses;
