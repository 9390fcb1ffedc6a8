//! Stages, their store, threads and progress.

mod campaign;
mod claims;
pub mod codec;
mod compare;
mod graph;
mod key;
mod manifest;
mod metrics;
mod progress;
mod results;
mod schedule;
pub mod stages;
mod store;
mod tables;
mod timing;

pub use campaign::{Campaign, Entry, PlannedRun};
pub use claims::{SEEDS_NEEDED, evaluate};
pub use compare::{Difference, compare};
pub use graph::{Artifact, Failure, Graph, Handle, Inputs, Kind};
pub use key::Key;
pub use manifest::{Manifest, StageTimes, stage_times};
pub use metrics::Tables;
pub use progress::{Progress, Style};
pub use results::{Files, Publication, PublishError, all_claims, write_files};
pub use schedule::{Need, Outcomes, execute, survey};
pub use store::{Lookup, Store};
pub use timing::Timing;
