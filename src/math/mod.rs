//! Numerics: small linear algebra, rotations, statistics.

pub mod polynomial;
pub mod rotation;
pub mod summary;
