//! Which stages are needed, and carrying them out on threads.

pub(super) mod executor;
pub(super) mod outcomes;
pub(super) mod plan;
pub(super) mod progress;
pub(super) mod remaining;
pub(super) mod stage_queue;
