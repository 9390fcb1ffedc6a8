//! Numerics: small linear algebra, rotations, statistics.

pub mod summary;
