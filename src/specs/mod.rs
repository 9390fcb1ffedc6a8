//! Experiments as YAML: strictly checked; an error names file, line, column and key.

mod check;
mod document;
mod experiment;
mod read;
mod schema;
mod sweep;
mod write;

pub use crate::plants::{PlantSpec, SimulatedSpec};
pub use document::error::{SourceLocation, SpecError};
pub use document::locate::{PathEnd, locate};
pub use document::merged::Document;
pub use document::path::{KeyPath, Step};
pub use document::suggest::nearest;
pub use experiment::cells::{
    gp_sizes, pace_cells, reach_cells, repair_cells, repair_worker, response_cells, track_cells,
    trial_cells,
};
pub use experiment::claims::{ClaimMetric, FrameAxis, PaperClaim, ReachCell, Relation, Size};
pub use experiment::repair::{RepairRecordings, RepairRun};
pub use experiment::scale::suited_travel_m;
pub use experiment::slurm::SlurmOptions;
pub use experiment::spec::{
    DiscoveryRun, Experiment, GapRun, GeneratedStart, PaceRun, ReachSweep, ResponseRun, Runs,
    TrackRun, Training, TrialMode,
};
pub use read::{files_behind, read_map, read_model, read_options, read_plant};
pub use schema::{SchemaOf, schema};
pub use sweep::experiment_set::{ExperimentSet, SweepPoint, SweptField};
pub use write::{differing_keys, extended_text, model_text, to_yaml};
