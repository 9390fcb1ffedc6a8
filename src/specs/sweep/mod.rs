//! Sweeps: the values of a field, and the experiment at each point of their product.

pub(super) mod experiment_set;
pub(super) mod series;
