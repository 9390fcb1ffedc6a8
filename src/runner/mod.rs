//! Stages, their store, threads and progress.

mod claims;
pub mod codec;
mod graph;
mod key;
mod metrics;
mod progress;
mod schedule;
pub mod stages;
mod store;
mod timing;

pub use claims::{SEEDS_NEEDED, evaluate};
pub use graph::{Artifact, Failure, Graph, Handle, Inputs, Kind};
pub use key::Key;
pub use metrics::Tables;
pub use progress::{Progress, Style};
pub use schedule::{Need, Outcomes, execute, survey};
pub use store::{Lookup, Store};
pub use timing::Timing;
