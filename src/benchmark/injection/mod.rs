//! What can be injected into a simulated robot: effects of the catalogue, and disturbances that are
//! in no catalogue.

pub(crate) mod disturbances;
pub(crate) mod injected_effects;
