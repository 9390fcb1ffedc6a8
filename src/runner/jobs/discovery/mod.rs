//! Blind cases of `discover`.

pub(crate) mod baselines;
pub(crate) mod blind;
pub(crate) mod blind_score;
pub(crate) mod discover;
