//! The discrete equations of one instant and their analytic derivative.

pub(crate) mod boundary_conditions;
pub(crate) mod contact;
pub(crate) mod homogenised_cells;
pub(crate) mod jacobian;
pub(crate) mod loads;
pub(crate) mod material;
pub(crate) mod motion;
pub(crate) mod rates;
pub(crate) mod shape;
pub(crate) mod system;
pub(crate) mod tendon_friction;
pub(crate) mod tendon_guide;
pub(crate) mod variation;
pub(crate) mod world_vectors;
