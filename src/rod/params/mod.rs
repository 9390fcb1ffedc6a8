//! TODO-DOC

pub(crate) mod hysteresis_law;
pub(crate) mod rod_params;
pub(crate) mod scheme;
pub(crate) mod span;
pub(crate) mod tendon;

