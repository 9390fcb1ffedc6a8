//! Recordings: exploration, replay, predefined points, targets, the path.

pub(crate) mod exploration;
pub(crate) mod gap;
pub(crate) mod gp_pool;
pub(crate) mod path;
pub(crate) mod samples;
pub(crate) mod targets;
