//! Blind cases of discovery (docs/blind_benchmark.md): a recording of a robot with something hidden in it, the truth
//! sealed beside it, and the score of an answer.
//!
//! The truth is not what is fitted: it is computed on a finer grid and with finer steps in time, the numbers that a lab
//! knows only so well are drawn anew for every robot, some effects follow another law of the same name, and noise is
//! added to all of it.

mod commands;
mod draw;
mod error;
mod hidden;
mod imitations;
mod metric;
mod options;
mod presented;
mod refit;
mod score;
mod span;
mod strength;
mod truth;
mod unknown;

pub use commands::{Commands, commands};
pub use draw::{Robot, draw};
pub use error::BlindError;
pub use hidden::Hidden;
pub use options::{Batch, Group, OracleOptions, Prior, TruthOptions};
pub use presented::{Presented, add_noise, present};
pub use score::{Answer, Answered, Scored, failed, score};
pub use span::Span;
pub use strength::{Reached, reach};
pub use truth::Truth;
pub use unknown::{Disturbance, UNKNOWNS, Unknown};
