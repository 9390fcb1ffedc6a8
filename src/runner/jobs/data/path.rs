//! The path of path tracking.

use crate::base::{Point3, Seed};
use crate::runner::graph::stage::{Handle, Stage, StageKind};
use crate::runner::jobs::parts::identified::Identified;
use crate::tasks::{self, PathOptions};

/// The points through which the path goes.
pub(crate) const WAYPOINTS: Stage<WaypointParams, (), Vec<Point3>> = Stage {
    kind: StageKind { name: "waypoints", module: module_path!(), cost_ms: 100 },
    job: |params, ()| {
        let mut robot = params.robot.build(&[], params.step_s)?;
        tasks::waypoints(robot.as_mut(), &params.options, Seed(0))
            .map_err(|error| error.to_string())
    },
};

/// The path through them.
pub(crate) const PATH: Stage<PathOptions, Handle<Vec<Point3>>, Vec<Point3>> = Stage {
    kind: StageKind { name: "path", module: module_path!(), cost_ms: 1 },
    job: |options, waypoints| {
        tasks::interpolate(waypoints, options).map_err(|error| error.to_string())
    },
};

/// Parameters of [`WAYPOINTS`].
#[derive(serde::Serialize)]
pub(crate) struct WaypointParams {
    /// Measured without noise.
    pub(crate) robot: Identified,
    pub(crate) options: PathOptions,
    pub(crate) step_s: f64,
}
