//! How good the answer to a blind case is.

use crate::benchmark::{
    self, BaselineAnswers, CaseAnswer, CaseAnswers, CaseBatch, CaseSetting, ScoredCase, Truth,
};
use crate::effects::Model;
use crate::runner::graph::stage::{Handle, Stage, StageKind};

/// Handles of what is hidden, of the answer of `discover` and of those of methods of comparison.
type ScoreInputs = (Handle<Truth>, Handle<CaseAnswer>, Handle<BaselineAnswers>);

/// The score of a case.
pub(crate) const SCORE: Stage<ScoreParams, ScoreInputs, ScoredCase> = Stage {
    kind: StageKind { name: "blind_score", module: module_path!(), cost_ms: 1 },
    job: |params, (truth, discover, baselines)| {
        let ScoreParams { case, batch, correlation, model } = params;
        let setting = CaseSetting { number: *case, batch, correlation: *correlation };
        Ok(benchmark::score(setting, model, truth, CaseAnswers { discover, baselines }))
    },
};

/// Parameters of [`SCORE`].
#[derive(serde::Serialize)]
pub(crate) struct ScoreParams {
    pub(crate) case: u64,
    pub(crate) batch: CaseBatch,
    pub(crate) correlation: f64,
    pub(crate) model: Model,
}
