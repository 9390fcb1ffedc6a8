//! Stages, their store, threads and progress.

mod campaign;
mod effect_curves;
mod execute;
mod graph;
mod jobs;
mod publish;
pub mod slurm;
pub mod stages;
mod store;

pub use campaign::{Campaign, CampaignEntry, PlannedRun};
pub use effect_curves::effect_pictures;
pub use execute::executor::{
    EXCHANGE_INTERVAL, MAX_PAUSE, MAX_RESULTS_IN_MEMORY, MAX_RESUMED_STAGES, MAX_UNWRITTEN_RESULTS,
    MIN_PAUSE, RunOptions, RunRecord, WorkerShare, execute, execute_share,
};
pub use execute::outcomes::{Outcomes, SharingCost};
pub use execute::plan::{Need, plan};
pub use execute::progress::{Progress, Style};
pub use execute::stage_queue::{StageQueue, WorkPlan};
pub use graph::Graph;
pub use graph::digest::Digest;
pub use graph::failure::Failure;
pub use graph::key::Key;
pub use graph::stage::{Handle, InputResults, Job, Stage, StageInputs, StageKind, StageResult};
pub use graph::timing::Timing;
pub use publish::claims::{SEEDS_NEEDED, evaluate};
pub use publish::compare::{Difference, Standard, compare};
pub use publish::compare_runs::{RunComparison, RunDifference, compare_runs, experiments_of_run};
pub use publish::discovery_files::{AskedDiscovery, DiscoveryFilesError, discovery_files};
pub use publish::failed_cells::FailedCell;
pub use publish::manifest::{Manifest, StageTimes, git_revision, processor, stage_times};
pub use publish::merge::{MergeError, merge};
pub use publish::metrics::Tables;
pub use publish::one_claim::published_cost;
pub use publish::provenance::{first_difference, provenance};
pub use publish::publish_all::{RunFacts, publish_all};
pub use publish::redraw::{redraw, redraw_claims};
pub use publish::results::{Files, Publication, PublishError, all_claims, put, write_files};
pub use store::{
    EntryLock, EntryState, Lookup, Note, Store, StoreTraffic, StoredEntry, store_folder,
};
