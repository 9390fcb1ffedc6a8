//! A spec as it is read: a file, the files it extends, and overrides from the command line, merged
//! into one tree that keeps the source location of each value.

pub(crate) mod alias;
pub(crate) mod error;
mod faults;
mod inherited;
mod invisible;
mod layer;
pub(crate) mod locate;
pub(in crate::specs) mod merge_keys;
pub(crate) mod merged;
pub(crate) mod mismatch;
pub(crate) mod path;
pub(super) mod suggest;
pub(crate) mod sweep;
mod sweep_option;
pub(crate) mod tree;

#[cfg(test)]
mod tests;
