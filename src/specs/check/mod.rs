//! What the types of a spec cannot express: ranges, and names and sizes that must agree.

mod claims;
pub(super) mod discovery;
pub(super) mod experiment;
mod named_values;
mod outside_policies;
mod repair;
