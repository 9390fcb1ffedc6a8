//! Stages, their store, threads and progress.

pub mod codec;
mod graph;
mod key;
mod progress;
mod schedule;
mod store;
mod timing;

pub use graph::{Artifact, Failure, Graph, Handle, Inputs, Kind};
pub use key::Key;
pub use progress::{Progress, Style};
pub use schedule::{Need, Outcomes, execute, survey};
pub use store::{Lookup, Store};
pub use timing::Timing;
