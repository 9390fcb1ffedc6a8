//! The recordings of a repair: a robot as it was built, and the changed one.

use super::exploration::ExploreParams;
use crate::base::Seed;
use crate::runner::stage::{Stage, StageKind};
use crate::tasks::{RecordedMotion, Transitions};

/// A recording of a robot.
pub(in crate::runner) const RECORD: Stage<RecordParams, (), Transitions> = Stage {
    kind: StageKind { name: "record", module: module_path!(), cost_ms: 500 },
    job: |RecordParams { motion, explore }, ()| {
        let mut robot = explore.model.build(&[], explore.step_s)?;
        let recorded = motion.record(robot.as_mut(), &explore.options, Seed(explore.seed));
        recorded.map_err(|error| error.to_string())
    },
};

/// Parameters of [`RECORD`].
#[derive(serde::Serialize)]
pub(in crate::runner) struct RecordParams {
    pub(in crate::runner) motion: RecordedMotion,
    /// The robot, and how far and how fast its tendons are pulled.
    pub(in crate::runner) explore: ExploreParams,
}
