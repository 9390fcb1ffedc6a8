//! The answer to a case: of the model, the recording and the options alone.

use std::path::PathBuf;

use serde::{Serialize, Serializer};

use crate::benchmark::{CaseAnswer, PublicCase};
use crate::data::Recording;
use crate::discovery::{Options, discover};
use crate::effects::Model;
use crate::runner::graph::stage::{Handle, Stage, StageKind};

/// The answer to a blind case, from the model and the options.
pub(crate) const DISCOVER: Stage<(Model, Options), Handle<PublicCase>, CaseAnswer> = Stage {
    kind: StageKind { name: "discover", module: module_path!(), cost_ms: 15_000 },
    job: |(model, options), presented| {
        answer(model, &presented.recording(), None, &options_for(presented, options))
    },
};

/// The answer to a recording of others.
pub(crate) const DISCOVER_RECORDED: Stage<RecordedParams, (), CaseAnswer> = Stage {
    kind: StageKind { name: "discover_recorded", module: module_path!(), cost_ms: 20_000 },
    job: |params, ()| {
        let baseline = params.baseline.as_ref().map(RecordedFile::read).transpose()?;
        answer(&params.model, &params.measured.read()?, baseline.as_ref(), &params.options)
    },
};

/// These options without the effects that are taken out of the catalogue for a case.
pub(crate) fn options_for(presented: &PublicCase, options: &Options) -> Options {
    let mut options = options.clone();
    options.left_out.extend(presented.left_out.iter().cloned());
    options
}

/// Parameters of [`DISCOVER_RECORDED`].
#[derive(Serialize)]
pub(crate) struct RecordedParams {
    pub(crate) model: Model,
    pub(crate) options: Options,
    pub(crate) measured: RecordedFile,
    pub(crate) baseline: Option<RecordedFile>,
}

/// A file that enters the key of a stage by its content, wherever it lies. One that cannot be read
/// fails the stage.
pub(crate) struct RecordedFile(pub(crate) PathBuf);

impl RecordedFile {
    pub(crate) fn read(&self) -> Result<Recording, String> {
        Recording::read(&self.0).map_err(|error| error.to_string())
    }
}

impl Serialize for RecordedFile {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(&std::fs::read(&self.0).unwrap_or_default())
    }
}

fn answer(
    model: &Model,
    measured: &Recording,
    baseline: Option<&Recording>,
    options: &Options,
) -> Result<CaseAnswer, String> {
    let discovery =
        discover(model, measured, baseline, options).map_err(|error| error.to_string())?;
    Ok(CaseAnswer::new(
        &discovery.findings,
        discovery.alternatives.stiffness_only_m,
        discovery.alternatives.gp_m,
    ))
}
