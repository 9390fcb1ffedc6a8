//! TODO-DOC

pub(crate) mod fields;
pub(crate) mod rod;
pub(crate) mod rod_state;
pub(crate) mod solve_log;

