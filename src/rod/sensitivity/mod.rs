//! Derivatives: of the tip and other places at rest, and of whole motions.

pub(crate) mod perturbed_rods;
pub(crate) mod tip_jacobian;
