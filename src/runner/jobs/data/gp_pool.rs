//! The predefined points of the Gaussian process.

use crate::base::Seed;
use crate::runner::graph::stage::{Stage, StageKind};
use crate::runner::jobs::parts::identified::Identified;
use crate::tasks::{self, GpPointsOptions, GpPool};

/// The points on model and robot.
pub(crate) const GP_POOL: Stage<PoolParams, (), GpPool> = Stage {
    kind: StageKind { name: "gp_pool", module: module_path!(), cost_ms: 4000 },
    job: |params, ()| {
        let (mut model, mut robot) =
            (params.model.build(&[], params.step_s)?, params.plant.build(&[], params.step_s)?);
        let pool =
            tasks::gp_points(model.as_mut(), robot.as_mut(), &params.options, Seed(params.seed));
        pool.map_err(|error| error.to_string())
    },
};

/// Parameters of [`GP_POOL`].
#[derive(serde::Serialize)]
pub(crate) struct PoolParams {
    pub(crate) model: Identified,
    pub(crate) plant: Identified,
    pub(crate) options: GpPointsOptions,
    pub(crate) step_s: f64,
    pub(crate) seed: u64,
}
