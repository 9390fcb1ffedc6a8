//! The rod in motion.

pub(crate) mod time_stepping;
