//! The error model after a change that was named: points from before it, and the rows that were
//! recorded after it.

use super::diagnosis::Diagnosis;
use crate::base::Seed;
use crate::effects::EffectSpec;
use crate::learn::gp::Gp;
use crate::runner::graph::stage::{Handle, Stage, StageKind};
use crate::runner::jobs::learning::gaussian_process::GpParams;
use crate::runner::jobs::parts::identified::Identified;
use crate::tasks::{self, GpPool, Transitions};

/// Handles of the predefined points, of the recording of the changed robot, and of the diagnosis.
type ChangedGpInputs = (Handle<GpPool>, Handle<Transitions>, Handle<Diagnosis>);

/// The process of eq. (20) about the repaired model, for networks that were trained on with it.
/// Where the diagnosis is right, the model as it was lacked of the robot before the change what the
/// repaired one lacks after it.
pub(crate) const GP_REPAIRED: Stage<GpRepairedParams, ChangedGpInputs, Gp> = Stage {
    kind: StageKind { name: "gp_repaired", module: module_path!(), cost_ms: 500 },
    job: |params, (pool, changed, diagnosis)| {
        let before = pool.points();
        let mut points = before.select(&params.gp.chosen(&before)?);
        points.extend(&params.replay(&diagnosis.effects, changed)?, changed);
        params.gp.fit(&points)
    },
};

/// The process about the model as it was, for networks that stay as they are: each real point is
/// moved by what the named lines do at its command, in the model.
pub(crate) const GP_MOVED: Stage<GpRepairedParams, ChangedGpInputs, Gp> = Stage {
    kind: StageKind { name: "gp_moved", module: module_path!(), cost_ms: 2000 },
    job: |params, (pool, changed, diagnosis)| {
        let before = pool.points();
        let moved = pool.moved(&params.replay(&diagnosis.effects, &pool.steps)?);
        let mut points = moved.select(&params.gp.chosen(&before)?);
        points.extend(&params.replay(&[], changed)?, changed);
        params.gp.fit(&points)
    },
};

/// Parameters of [`GP_REPAIRED`] and [`GP_MOVED`].
#[derive(serde::Serialize)]
pub(crate) struct GpRepairedParams {
    pub(crate) model: Identified,
    pub(crate) step_s: f64,
    pub(crate) gp: GpParams,
}

impl GpRepairedParams {
    /// The commands of `steps` on the model with these lines.
    fn replay(&self, lines: &[EffectSpec], steps: &Transitions) -> Result<Transitions, String> {
        let mut plant = self.model.build(lines, self.step_s)?;
        tasks::replay(plant.as_mut(), steps, Seed(0)).map_err(|error| error.to_string())
    }
}
