//! Blind benchmark of discovery (docs/evidence/blind_benchmark.md): a recording of a robot with an injected
//! effect, the sealed truth, and the score of an answer.
//!
//! The truth differs from the fitted model: finer grid and time steps, uncertain parameters drawn
//! anew for every robot, other laws for some effects, and noise.
//!
//! Order: options and commands, `injection` (effects and disturbances), `truth`, `oracle` (what the
//! catalogue can imitate), `drawing` (of a case), `public_case`, `recorded` (cases of others),
//! `baselines` (methods of comparison), `scores`.

mod baselines;
mod commands;
mod drawing;
mod error;
mod injection;
mod options;
mod oracle;
mod public_case;
mod recorded;
mod scores;
mod truth;

pub use baselines::{BaselineAnswer, BaselineAnswers, baseline_answers};
pub use commands::{Commands, explore_commands};
pub use drawing::population::{DrawnEffect, Population};
pub use drawing::scale_to_shift::{ScaledStrength, scale_to_shift};
pub use drawing::{CaseDesign, draw};
pub use error::BenchmarkError;
pub use injection::disturbances::{DISTURBANCES, Disturbance, DisturbanceKind};
pub use injection::injected_effects::{InjectedEffect, drawn_catalogue};
pub use options::{CaseBatch, CaseGroup, OracleOptions, Prior, TruthOptions};
pub use oracle::{CatalogueSpan, Imitated};
pub use public_case::{PublicCase, add_noise, measure_case};
pub use recorded::{RecordedCase, RecordedCases};
pub use scores::{AnsweredEffect, CaseAnswer, CaseAnswers, CaseSetting, ScoredCase, failed, score};
pub use truth::Truth;
