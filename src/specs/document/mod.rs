//! A spec as it is read: a file, the files it extends, and overrides from the command line, merged into one tree that
//! keeps the source location of each value.

pub(in crate::specs) mod alias;
pub(in crate::specs) mod error;
mod faults;
mod layer;
pub(in crate::specs) mod locate;
pub(in crate::specs) mod merged;
pub(in crate::specs) mod mismatch;
pub(in crate::specs) mod path;
mod suggest;
pub(in crate::specs) mod sweep;
mod sweep_option;
pub(in crate::specs) mod tree;

#[cfg(test)]
mod tests;
