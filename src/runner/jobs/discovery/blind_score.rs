//! How good the answer to a blind case is.

use crate::benchmark::{self, CaseAnswer, CaseBatch, CaseSetting, ScoredCase, Truth};
use crate::effects::Model;
use crate::runner::graph::stage::{Handle, Stage, StageKind};

/// The score of a case.
pub(crate) const SCORE: Stage<ScoreParams, (Handle<Truth>, Handle<CaseAnswer>), ScoredCase> =
    Stage {
        kind: StageKind { name: "blind_score", module: module_path!(), cost_ms: 1 },
        job: |params, (truth, answer)| {
            let ScoreParams { case, batch, correlation, model } = params;
            let setting = CaseSetting { number: *case, batch, correlation: *correlation };
            Ok(benchmark::score(setting, model, truth, answer))
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
