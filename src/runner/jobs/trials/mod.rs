//! Trials of one policy.

pub(in crate::runner) mod reach_track;
pub(in crate::runner) mod responses;
