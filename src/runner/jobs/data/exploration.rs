//! The random exploration, on the model and on the robot.

use crate::base::Seed;
use crate::runner::graph::stage::{Handle, Stage, StageKind};
use crate::runner::jobs::parts::identified::Identified;
use crate::tasks::{self, ExploreOptions, Transitions};

/// The exploration on the model.
pub(in crate::runner) const EXPLORE: Stage<ExploreParams, (), Transitions> = Stage {
    kind: StageKind { name: "collect_sim", module: module_path!(), cost_ms: 14_000 },
    job: |params, ()| {
        let mut plant = params.model.build(&[], params.step_s)?;
        tasks::explore(plant.as_mut(), &params.options, Seed(params.seed)).map_err(|error| error.to_string())
    },
};

/// The same commands on the robot.
pub(in crate::runner) const REPLAY: Stage<ReplayParams, Handle<Transitions>, Transitions> = Stage {
    kind: StageKind { name: "collect_real", module: module_path!(), cost_ms: 20_000 },
    job: |params, explored| {
        let mut plant = params.plant.build(&[], params.step_s)?;
        tasks::replay(plant.as_mut(), explored, Seed(params.seed)).map_err(|error| error.to_string())
    },
};

/// Parameters of [`EXPLORE`].
#[derive(serde::Serialize)]
pub(in crate::runner) struct ExploreParams {
    pub(in crate::runner) model: Identified,
    pub(in crate::runner) options: ExploreOptions,
    pub(in crate::runner) step_s: f64,
    pub(in crate::runner) seed: u64,
}

/// Parameters of [`REPLAY`].
#[derive(serde::Serialize)]
pub(in crate::runner) struct ReplayParams {
    pub(in crate::runner) plant: Identified,
    pub(in crate::runner) step_s: f64,
    pub(in crate::runner) seed: u64,
}
