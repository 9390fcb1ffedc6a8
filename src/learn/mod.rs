//! Learning: Gaussian processes ([`gp`]), recurrent networks ([`rnn`]) and the optimiser behind the first
//! ([`optimise`]). Decisions and figures: `docs/learning.md`.

mod error;
mod exact;
mod simd;
mod standardise;

pub mod gp;
pub mod rnn;

pub use error::LearnError;
pub use standardise::Standardiser;
