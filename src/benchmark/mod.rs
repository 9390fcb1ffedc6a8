//! Blind cases of discovery (docs/blind_benchmark.md): a recording of a robot with something hidden in it, the truth
//! sealed beside it, and the score of an answer.
//!
//! The truth is not what is fitted: it is computed on a finer grid and with finer steps in time, the numbers that a lab
//! knows only so well are drawn anew for every robot, some effects follow another law of the same name, and noise is
//! added to all of it.

mod commands;
mod drawing;
mod error;
mod options;
mod oracle;
mod public_case;
mod scores;
mod truth;

pub use commands::{Commands, commands};
pub use drawing::disturbances::{Disturbance, UNKNOWNS, Unknown};
pub use drawing::injected_effects::Hidden;
pub use drawing::scale_to_shift::{Reached, reach};
pub use drawing::{Robot, draw};
pub use error::BlindError;
pub use options::{Batch, Group, OracleOptions, Prior, TruthOptions};
pub use oracle::Span;
pub use public_case::{Presented, add_noise, present};
pub use scores::{Answer, Answered, Scored, failed, score};
pub use truth::Truth;
