//! Recordings: exploration, replay, predefined points, targets, the path.

pub(in crate::runner) mod exploration;
pub(in crate::runner) mod gap;
pub(in crate::runner) mod gp_pool;
pub(in crate::runner) mod path;
pub(in crate::runner) mod samples;
pub(in crate::runner) mod targets;
