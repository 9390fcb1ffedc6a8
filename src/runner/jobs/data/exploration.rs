//! The random exploration, on the model and on the robot.

use crate::base::Seed;
use crate::runner::graph::stage::{Handle, Stage, StageKind};
use crate::runner::jobs::parts::identified::Identified;
use crate::tasks::{self, ExploreOptions, Transitions};

/// The exploration on the model.
pub(crate) const EXPLORE: Stage<ExploreParams, (), Transitions> = Stage {
    kind: StageKind { name: "collect_sim", module: module_path!(), cost_ms: 14_000 },
    job: |params, ()| {
        let mut plant = params.model.build(&[], params.step_s)?;
        tasks::explore(plant.as_mut(), &params.options, Seed(params.seed))
            .map_err(|error| error.to_string())
    },
};

/// The same commands on the robot.
pub(crate) const REPLAY: Stage<ReplayParams, Handle<Transitions>, Transitions> = Stage {
    kind: StageKind { name: "collect_real", module: module_path!(), cost_ms: 20_000 },
    job: |params, explored| {
        let mut plant = params.plant.build(&[], params.step_s)?;
        tasks::replay(plant.as_mut(), explored, Seed(params.seed))
            .map_err(|error| error.to_string())
    },
};

/// Parameters of [`EXPLORE`].
#[derive(serde::Serialize)]
pub(crate) struct ExploreParams {
    pub(crate) model: Identified,
    pub(crate) options: ExploreOptions,
    pub(crate) step_s: f64,
    pub(crate) seed: u64,
}

/// Parameters of [`REPLAY`].
#[derive(serde::Serialize)]
pub(crate) struct ReplayParams {
    pub(crate) plant: Identified,
    pub(crate) step_s: f64,
    pub(crate) seed: u64,
}
