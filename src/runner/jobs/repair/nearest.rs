//! How near a changed robot can come to the targets, which were drawn from what the unchanged one
//! reaches.

use crate::base::Point3;
use crate::effects::EffectSpec;
use crate::policies::nearest_at_rest_m;
use crate::runner::graph::stage::{Handle, Stage, StageKind};
use crate::runner::jobs::parts::identified::Identified;
use crate::tasks;

/// The mean distance of the targets from the nearest place where the tip comes to rest, metres.
pub(crate) const NEAREST: Stage<NearestParams, Handle<Vec<(usize, Point3)>>, f64> = Stage {
    kind: StageKind { name: "nearest", module: module_path!(), cost_ms: 3000 },
    job: |params, targets| {
        let targets_m: Vec<Point3> = targets.iter().map(|(_, target_m)| *target_m).collect();
        let robot = params.robot.spec().with_effects(&params.effects);
        let model = tasks::tip_model(&robot).ok_or("the robot has no equilibrium equations")?;
        let layout = robot.build(params.step_s)?.tendon_layout();
        let distances_m = nearest_at_rest_m(model, layout, params.travel_m, &targets_m);
        let mean_m = crate::math::summary::mean(&distances_m);
        if mean_m.is_finite() {
            Ok(mean_m)
        } else {
            Err("the robot does not reach equilibrium".to_owned())
        }
    },
};

/// Parameters of [`NEAREST`].
#[derive(serde::Serialize)]
pub(crate) struct NearestParams {
    pub(crate) robot: Identified,
    /// What has changed.
    pub(crate) effects: Vec<EffectSpec>,
    /// Farthest that a tendon is pulled, metres.
    pub(crate) travel_m: f64,
    pub(crate) step_s: f64,
}
