//! Cells along the rod and the polynomials of the internal wrench on them.

pub(crate) mod basis;
pub(crate) mod cell;
pub(crate) mod grid;
pub(crate) mod levels;
pub(crate) mod transfer;
