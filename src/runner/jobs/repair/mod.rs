//! A robot changes: what is noticed, diagnosed and repaired.

pub(in crate::runner) mod diagnose;
pub(in crate::runner) mod diagnosis;
pub(in crate::runner) mod gp_repaired;
pub(in crate::runner) mod nearest;
pub(in crate::runner) mod repaired;
pub(in crate::runner) mod retrain;
pub(in crate::runner) mod work;
