//! Parts of parameters: each is digested once.

pub(in crate::runner) mod identified;
pub(in crate::runner) mod outside_part;
pub(in crate::runner) mod shared_part;
