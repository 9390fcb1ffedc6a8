//! Newton's method on the discrete equations, with an active set for taut and slack tendons.

pub(crate) mod active_set;
mod contact_search;
pub(crate) mod factors;
pub(crate) mod newton;
pub(crate) mod newton_damping;
pub(crate) mod newton_state;
pub(crate) mod status;
