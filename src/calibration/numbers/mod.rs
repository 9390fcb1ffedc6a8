//! The numbers of a model that a fit changes.

pub(super) mod entry;
pub(super) mod idle;
pub(super) mod number;
pub(super) mod path;
