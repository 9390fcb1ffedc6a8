//! Blind cases of discovery: what is hidden, and the recording that is made from it.

use crate::base::Seed;
use crate::benchmark::{self, CaseDesign, CatalogueSpan, Commands, Prior, PublicCase, Truth};
use crate::effects::Model;
use crate::runner::graph::stage::{Handle, Stage, StageKind};
use crate::tasks::ExploreOptions;

/// The commands of a case.
pub(crate) const COMMANDS: Stage<CommandParams, (), Commands> = Stage {
    kind: StageKind { name: "blind_commands", module: module_path!(), cost_ms: 300 },
    job: |params, ()| {
        let commands = benchmark::explore_commands(
            &params.model,
            &params.explore,
            params.step_s,
            Seed(params.seed),
        );
        commands.map_err(|error| error.to_string())
    },
};

/// What the catalogue can imitate under these commands.
pub(crate) const SPAN: Stage<SpanParams, Handle<Commands>, CatalogueSpan> = Stage {
    kind: StageKind { name: "blind_span", module: module_path!(), cost_ms: 15_000 },
    job: |params, commands| {
        CatalogueSpan::new(&params.model, commands, &params.priors, params.noise_m)
            .map_err(|error| error.to_string())
    },
};

/// Handles of the commands and, where the oracle judges the case, of what the catalogue can
/// imitate.
type TruthInputs = (Handle<Commands>, Option<Handle<CatalogueSpan>>);
/// Handles of what is hidden and of the commands.
type RecordingInputs = (Handle<Truth>, Handle<Commands>);

/// What is hidden: the sealed label.
pub(crate) const TRUTH: Stage<CaseDesign, TruthInputs, Truth> = Stage {
    kind: StageKind { name: "blind_truth", module: module_path!(), cost_ms: 3_000 },
    job: |robot, (commands, span)| {
        benchmark::draw(robot, commands, span).map_err(|error| error.to_string())
    },
};

/// The recording: of the robot and of the correlation of its noise.
pub(crate) const RECORDING: Stage<(CaseDesign, f64), RecordingInputs, PublicCase> = Stage {
    kind: StageKind { name: "blind_recording", module: module_path!(), cost_ms: 500 },
    job: |(robot, correlation), (truth, commands)| {
        benchmark::measure_case(robot, truth, commands, *correlation)
            .map_err(|error| error.to_string())
    },
};

/// The truth of a recording of others, which their table tells.
pub(crate) const RECORDED_TRUTH: Stage<Truth, (), Truth> = Stage {
    kind: StageKind { name: "recorded_truth", module: module_path!(), cost_ms: 1 },
    job: |truth, ()| Ok(truth.clone()),
};

/// Parameters of [`COMMANDS`].
#[derive(serde::Serialize)]
pub(crate) struct CommandParams {
    pub(crate) model: Model,
    pub(crate) explore: ExploreOptions,
    pub(crate) step_s: f64,
    pub(crate) seed: u64,
}

/// Parameters of [`SPAN`].
#[derive(serde::Serialize)]
pub(crate) struct SpanParams {
    pub(crate) model: Model,
    pub(crate) priors: Vec<Prior>,
    pub(crate) noise_m: f64,
}
