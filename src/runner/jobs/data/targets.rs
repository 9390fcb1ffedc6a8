//! The targets of goal reaching.

use crate::base::{Point3, Seed};
use crate::runner::graph::stage::{Handle, Stage, StageKind};
use crate::runner::jobs::parts::identified::Identified;
use crate::tasks::{self, TargetOptions};

/// Targets with their numbers in the pool, metres.
pub(crate) type Targets = Vec<(usize, Point3)>;

/// All points that may become targets.
pub(crate) const TARGET_POOL: Stage<TargetPoolParams, (), Vec<Point3>> = Stage {
    kind: StageKind { name: "target_pool", module: module_path!(), cost_ms: 4000 },
    job: |params, ()| {
        let mut robot = params.robot.build(&[], params.step_s)?;
        tasks::target_pool(robot.as_mut(), &params.options, Seed(0))
            .map_err(|error| error.to_string())
    },
};

/// The targets that are drawn: their number and the seed.
pub(crate) const TARGETS: Stage<(usize, u64), Handle<Vec<Point3>>, Targets> = Stage {
    kind: StageKind { name: "targets", module: module_path!(), cost_ms: 1 },
    job: |&(drawn, seed), pool| {
        tasks::draw_targets(pool, drawn, Seed(seed)).map_err(|error| error.to_string())
    },
};

/// Parameters of [`TARGET_POOL`].
#[derive(serde::Serialize)]
pub(crate) struct TargetPoolParams {
    /// Measured without noise.
    pub(crate) robot: Identified,
    pub(crate) options: TargetOptions,
    pub(crate) step_s: f64,
}
