//! Learning: Gaussian processes ([`gp`]) and recurrent networks ([`rnn`]). Decisions and figures: `docs/learning.md`.

mod error;
mod exact;
mod simd;
mod standardise;

pub mod gp;
pub mod rnn;

pub use error::LearnError;
pub use standardise::Standardiser;
