//! The search for the effects that are missing: one after the other, then each against all others in its place, then
//! without each; then from pairs that this did not lead to.

pub(crate) mod add_effect;
pub(crate) mod fit_additions;
pub(crate) mod forward_step;
pub(crate) mod grow;
pub(crate) mod large_amplitude;
pub(crate) mod pair_step;
pub(crate) mod screening;
pub(crate) mod state;
pub(crate) mod swap;

pub(crate) use state::{ScoredSet, Search, SearchOutcome};
