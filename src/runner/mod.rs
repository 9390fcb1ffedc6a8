//! Stages, their store, threads and progress.

mod campaign;
mod claims;
pub mod codec;
mod compare;
mod digest;
mod executor;
mod failure;
mod graph;
mod jobs;
mod key;
mod manifest;
mod merge;
mod metrics;
mod outcomes;
mod plan;
mod progress;
mod provenance;
mod publish_all;
mod remaining;
mod repair_tables;
mod results;
pub mod slurm;
mod source_digest;
mod stage;
mod stage_queue;
pub mod stages;
mod store;
mod sweep;
mod tables;
mod timing;

pub use campaign::{Campaign, CampaignEntry, PlannedRun};
pub use claims::{SEEDS_NEEDED, evaluate};
pub use compare::{Difference, Standard, compare};
pub use digest::Digest;
pub use executor::{
    EXCHANGE, HELD_RESULTS, LONGEST_PAUSE, RESUMED, RunOptions, RunRecord, SHORTEST_PAUSE, UNWRITTEN_RESULTS,
    WorkerShare, execute, execute_share,
};
pub use failure::Failure;
pub use graph::Graph;
pub use key::Key;
pub use manifest::{Manifest, StageTimes, git_revision, processor, stage_times};
pub use merge::{MergeError, merge};
pub use metrics::Tables;
pub use outcomes::{Outcomes, SharingCost};
pub use plan::{Need, plan};
pub use progress::{Progress, Style};
pub use provenance::{first_difference, provenance};
pub use publish_all::{RunFacts, publish_all};
pub use results::{Files, Publication, PublishError, all_claims, put, write_files};
pub use stage::{Handle, InputResults, Job, Stage, StageInputs, StageKind, StageResult};
pub use stage_queue::{StageQueue, WorkPlan};
pub use store::{EntryLock, EntryState, Lookup, Note, Store, StoreTraffic, StoredEntry};
pub use timing::Timing;
