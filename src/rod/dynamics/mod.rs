//! The rod in motion.

pub(crate) mod scheme;
pub(crate) mod solve_log;
pub(crate) mod time_stepping;
