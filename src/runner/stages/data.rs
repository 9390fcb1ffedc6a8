//! The stages of recordings: exploration, replay, predefined points, targets, the path.

use super::{Added, Stages};
use crate::base::Point3;
use crate::rows::experiment::GapSample;
use crate::runner::jobs::data::exploration::{EXPLORE, ExploreParams, REPLAY, ReplayParams};
use crate::runner::jobs::data::gap::GAP;
use crate::runner::jobs::data::gp_pool::{GP_POOL, PoolParams};
use crate::runner::jobs::data::path::{PATH, WAYPOINTS, WaypointParams};
use crate::runner::jobs::data::targets::{TARGET_POOL, TARGETS, TargetPoolParams, Targets};
use crate::runner::jobs::parts::identified::Identified;
use crate::tasks::{GpPool, SimulatedBy, Transitions};

impl Stages<'_> {
    /// The random exploration on the model.
    pub(crate) fn explore(&mut self) -> Added<Transitions> {
        self.once((EXPLORE.kind.name, None, 0), |stages| {
            stages.graph.stage(&EXPLORE, stages.label("exploration"), stages.explore_params(), ())
        })
    }

    /// The exploration as the spec describes it.
    pub(super) fn explore_params(&self) -> ExploreParams {
        let (options, step_s, seed) =
            (self.spec.explore, self.step_s(), self.seed.child("explore").0);
        ExploreParams { model: self.parts.model.clone(), options, step_s, seed }
    }

    /// The same commands on the robot.
    pub(crate) fn replay(&mut self) -> Added<Transitions> {
        self.once((REPLAY.kind.name, None, 0), |stages| {
            let explored = stages.explore()?;
            let (step_s, seed) = (stages.step_s(), stages.seed.child("replay").0);
            let params = ReplayParams { plant: stages.parts.plant.clone(), step_s, seed };
            stages.graph.stage(&REPLAY, stages.label("replay"), params, explored)
        })
    }

    /// Model and robot side by side, `rows` samples spread over the exploration.
    pub(crate) fn gap(&mut self, rows: usize) -> Added<Vec<GapSample>> {
        let inputs = (self.explore()?, self.replay()?);
        self.graph.stage(&GAP, self.label("gap"), rows, inputs)
    }

    /// The predefined points of the Gaussian process, on model and robot.
    pub(crate) fn gp_pool(&mut self) -> Added<GpPool> {
        self.once((GP_POOL.kind.name, None, 0), |stages| {
            stages.pool_of(stages.parts.plant.clone(), "predefined points")
        })
    }

    /// The predefined points on model and a robot.
    pub(super) fn pool_of(&mut self, plant: Identified, label: &str) -> Added<GpPool> {
        let (model, mut options) = (self.parts.model.clone(), self.spec.gp_points);
        // The recording is the same whatever p_sim is later taken from.
        options.p_sim = SimulatedBy::Rod;
        let (step_s, seed) = (self.step_s(), self.seed.child("gp_pool").0);
        let params = PoolParams { model, plant, options, step_s, seed };
        self.graph.stage(&GP_POOL, self.label(label), params, ())
    }

    /// All points that may become targets: of the robot without measurement noise, the same for
    /// every seed.
    pub(super) fn target_pool(&mut self) -> Added<Vec<Point3>> {
        let mut options = self.spec.targets;
        options.drawn = 1; // how many are drawn later does not change the pool
        let params =
            TargetPoolParams { robot: self.parts.quiet.clone(), options, step_s: self.step_s() };
        self.graph.stage(&TARGET_POOL, "target pool", params, ())
    }

    /// The targets of this repetition: the same for every policy.
    pub(crate) fn targets(&mut self) -> Added<Targets> {
        self.once((TARGETS.kind.name, None, 0), |stages| {
            let pool = stages.target_pool()?;
            let params = (stages.spec.targets.drawn, stages.seed.child("targets").0);
            stages.graph.stage(&TARGETS, stages.label("targets"), params, pool)
        })
    }

    /// The points through which the path goes: of the robot without measurement noise, the same for
    /// every seed.
    pub(crate) fn waypoints(&mut self) -> Added<Vec<Point3>> {
        let (robot, options, step_s) = (self.parts.quiet.clone(), self.spec.path, self.step_s());
        self.graph.stage(&WAYPOINTS, "way-points", WaypointParams { robot, options, step_s }, ())
    }

    /// The path that is tracked.
    pub(crate) fn path(&mut self) -> Added<Vec<Point3>> {
        self.once((PATH.kind.name, None, 0), |stages| {
            let waypoints = stages.waypoints()?;
            stages.graph.stage(&PATH, "path", stages.spec.path, waypoints)
        })
    }
}
