//! Small numerics that several rooms share.

pub mod polynomial;
pub mod rotation;
