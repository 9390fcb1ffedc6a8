//! Parts of parameters: each is digested once.

pub(crate) mod identified;
pub(crate) mod outside_part;
pub(crate) mod shared_part;
