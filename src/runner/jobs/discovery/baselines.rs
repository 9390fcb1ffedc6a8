//! What methods of comparison say of a case: of the model, the recording and the options alone.

use super::discover::{RecordedFile, RecordedParams, options_for};
use crate::benchmark::{BaselineAnswers, PublicCase, baseline_answers};
use crate::data::Recording;
use crate::discovery::{Options, linear_problem};
use crate::effects::Model;
use crate::runner::graph::stage::{Handle, Stage, StageKind};

/// The answers to a blind case, from the model and the options.
pub(crate) const BASELINES: Stage<(Model, Options), Handle<PublicCase>, BaselineAnswers> = Stage {
    kind: StageKind { name: "baselines", module: module_path!(), cost_ms: 6_000 },
    job: |(model, options), presented| {
        answers(model, &presented.recording(), None, &options_for(presented, options))
    },
};

/// The answers to a recording of others.
pub(crate) const BASELINES_RECORDED: Stage<RecordedParams, (), BaselineAnswers> = Stage {
    kind: StageKind { name: "baselines_recorded", module: module_path!(), cost_ms: 8_000 },
    job: |params, ()| {
        let baseline = params.baseline.as_ref().map(RecordedFile::read).transpose()?;
        answers(&params.model, &params.measured.read()?, baseline.as_ref(), &params.options)
    },
};

fn answers(
    model: &Model,
    measured: &Recording,
    baseline: Option<&Recording>,
    options: &Options,
) -> Result<BaselineAnswers, String> {
    let problem = linear_problem(model, measured, baseline, options);
    Ok(baseline_answers(&problem.map_err(|error| error.to_string())?))
}
