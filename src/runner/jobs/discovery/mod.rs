//! Blind cases of `discover`.

pub(in crate::runner) mod blind;
pub(in crate::runner) mod blind_score;
pub(in crate::runner) mod discover;
