//! Search over candidate sets: forward steps, swaps, removals, then pairs that single effects do
//! not lead to.

pub(crate) mod add_effect;
pub(crate) mod fit_additions;
pub(crate) mod forward_step;
pub(crate) mod grow;
pub(crate) mod large_amplitude;
pub(crate) mod pair_step;
pub(crate) mod screening;
pub(crate) mod state;
pub(crate) mod swap;

pub(crate) use state::{ScoredSet, Search, SearchOutcome, TrialEvidence};
