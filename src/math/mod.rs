//! Numerics: small linear algebra, rotations, statistics.

pub mod distribution;
pub mod optimise;
pub mod polynomial;
pub mod rotation;
pub mod summary;
pub mod three;
mod vector_units;

pub use vector_units::vectorised;
