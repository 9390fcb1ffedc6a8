//! Numerics: small linear algebra, rotations, statistics, minimisation.

pub mod distribution;
pub mod matrix3;
pub mod optimise;
pub mod polynomial;
pub mod rotation;
mod simd_dispatch;
pub mod summary;

pub(crate) use simd_dispatch::{dispatch, vectorised};
