//! Experiments as YAML: strictly checked, with the file, line and key of whatever is wrong.

mod alias;
mod cells;
mod check;
mod check_claims;
mod claims;
mod discovery;
mod document;
mod error;
mod experiment;
mod experiment_set;
mod locate;
mod mismatch;
mod model;
mod path;
mod plant;
mod schema;
mod series;
mod slurm;
mod suggest;
mod sweep_option;

pub use cells::{TrialCell, gp_sizes, reach_cells, track_cells};
pub use claims::{ClaimMetric, FrameAxis, PaperClaim, ReachCell, Relation, Size};
pub use document::Document;
pub use error::{SourceLocation, SpecError};
pub use experiment::{
    DiscoveryRun, Experiment, GapRun, GeneratedStart, ReachSweep, Runs, TrackRun, Training, TrialMode,
};
pub use experiment_set::{ExperimentSet, SweepPoint, SweptField};
pub use locate::{PathEnd, locate};
pub use model::{extended_text, files_behind, model_text, read_model, read_options, read_plant};
pub use path::{KeyPath, Step};
pub use plant::{PlantSpec, SimulatedSpec};
pub use schema::{SchemaOf, schema};
pub use slurm::SlurmOptions;

use serde::Serialize;
use std::path::Path;

/// A value as YAML in the form in which specs are read.
///
/// # Errors
/// What the serialiser says, for a type that YAML cannot hold.
pub fn to_yaml<T: Serialize>(value: &T) -> Result<String, String> {
    let mut text = Vec::new();
    let mut serializer = serde_yaml::Serializer::new(&mut text);
    serde_yaml::with::singleton_map_recursive::serialize(value, &mut serializer).map_err(|error| error.to_string())?;
    String::from_utf8(text).map_err(|error| error.to_string())
}

impl Experiment {
    /// Reads and checks a spec with overrides `path.to.key=value`; one that sweeps is a [`ExperimentSet`].
    ///
    /// # Errors
    /// [`SpecError`] for the first thing that is wrong.
    pub fn read(file: &Path, sets: &[String]) -> Result<Experiment, SpecError> {
        let experiment_set = ExperimentSet::read(file, sets, &[])?;
        let swept = experiment_set.sweep.first().map(|field| SpecError::File {
            file: file.display().to_string(),
            found: format!("a sweep of `{}`", field.name),
            expected: "a spec that sweeps nothing",
        });
        swept.map_or(Ok(experiment_set.experiment), Err)
    }
}
