//! Learning: Gaussian processes ([`gp`]), recurrent networks ([`rnn`]) and networks that others have trained ([`onnx`]).
//! Decisions and figures: `docs/learning.md`.

mod error;
mod exact;
mod simd;
mod standardise;

pub mod gp;
pub mod onnx;
pub mod rnn;

pub use error::LearnError;
pub use standardise::Standardiser;
