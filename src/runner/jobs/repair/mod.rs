//! A robot changes: what is noticed, diagnosed and repaired.

pub(crate) mod diagnose;
pub(crate) mod diagnosis;
pub(crate) mod gp_repaired;
pub(crate) mod nearest;
pub(crate) mod repaired;
pub(crate) mod retrain;
pub(crate) mod work;
