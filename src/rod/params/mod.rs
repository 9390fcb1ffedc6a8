//! Parameters of a rod: cross-sections, spine, tendons, loads, moment laws, resolution.

pub(crate) mod contact;
pub(crate) mod hysteresis_law;
pub(crate) mod loads;
pub(crate) mod obstacle;
pub(crate) mod resolution;
pub(crate) mod rod_params;
pub(crate) mod scheme;
pub(crate) mod span;
pub(crate) mod spine;
pub(crate) mod tendon;
