//! Blind cases of discovery (docs/blind_benchmark.md): a recording of a robot with something hidden in it, the truth
//! sealed beside it, and the score of an answer.
//!
//! The truth is not what is fitted: it is computed on a finer grid and with finer steps in time, the numbers that a lab
//! knows only so well are drawn anew for every robot, some effects follow another law of the same name, and noise is
//! added to all of it.

mod commands;
mod drawing;
mod error;
mod injection;
mod options;
mod oracle;
mod public_case;
mod scores;
mod truth;

pub use commands::{Commands, explore_commands};
pub use drawing::scale_to_shift::{ScaledStrength, scale_to_shift};
pub use drawing::{CaseDesign, draw};
pub use error::BenchmarkError;
pub use injection::disturbances::{DISTURBANCES, Disturbance, DisturbanceKind};
pub use injection::injected_effects::InjectedEffect;
pub use options::{CaseBatch, CaseGroup, OracleOptions, Prior, TruthOptions};
pub use oracle::CatalogueSpan;
pub use public_case::{PublicCase, add_noise, measure_case};
pub use scores::{AnsweredEffect, CaseAnswer, ScoredCase, failed, score};
pub use truth::Truth;
