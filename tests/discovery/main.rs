//! What `discover` says of recordings in which something is hidden, or nothing.

#[path = "../support/mod.rs"]
mod support;

mod benchmark;
mod hidden;
mod mistakes;
mod per_verdict;
mod proof;
mod recordings;
mod report_benchmark;
mod report_discovery;
mod rounds;
mod silence;
mod verdicts;
