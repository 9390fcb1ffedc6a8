//! The keys of a spec, the cells that it runs, and the plants and claims that it names.

pub(super) mod cells;
pub(super) mod claims;
pub(super) mod repair;
pub(super) mod scale;
pub(super) mod slurm;
pub(super) mod spec;
