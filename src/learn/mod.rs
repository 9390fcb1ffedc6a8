//! Learning: Gaussian processes ([`gp`]), recurrent networks ([`networks`]), networks that others
//! have trained ([`onnx`]) and which points are measured ([`selection`]). Decisions and figures:
//! `docs/method/learning.md`.

mod error;
mod exact;
mod simd;
mod standardise;

pub mod gp;
pub mod networks;
pub mod onnx;
pub mod selection;

pub use error::LearnError;
pub use standardise::Standardiser;
