//! Recordings: exploration, replay, predefined points, targets, the path.

use super::{Added, Stages, status};
use crate::base::{Point3, Seed};
use crate::data::rows::GapRow;
use crate::runner::graph::StageKind;
use crate::runner::source_digest::ROBOT;
use crate::tasks::{self, GpPool, SimulatedBy, Transitions};

const EXPLORE: StageKind = StageKind { name: "collect_sim", sources: ROBOT, cost_ms: 14000 };
const REPLAY: StageKind = StageKind { name: "collect_real", sources: ROBOT, cost_ms: 20000 };
const GAP: StageKind = StageKind { name: "gap", sources: ROBOT, cost_ms: 20 };
const GP_POOL: StageKind = StageKind { name: "gp_pool", sources: ROBOT, cost_ms: 4000 };
const TARGET_POOL: StageKind = StageKind { name: "target_pool", sources: ROBOT, cost_ms: 4000 };
const TARGETS: StageKind = StageKind { name: "targets", sources: ROBOT, cost_ms: 1 };
const WAYPOINTS: StageKind = StageKind { name: "waypoints", sources: ROBOT, cost_ms: 100 };
const PATH: StageKind = StageKind { name: "path", sources: ROBOT, cost_ms: 1 };
/// All of this file.
pub(super) const KINDS: [StageKind; 8] = [EXPLORE, REPLAY, GAP, GP_POOL, TARGET_POOL, TARGETS, WAYPOINTS, PATH];

/// Targets with their numbers in the pool, metres.
pub(super) type Targets = Vec<(usize, Point3)>;

impl Stages<'_> {
    /// The random exploration on the model.
    pub(crate) fn explore(&mut self) -> Added<Transitions> {
        self.once((EXPLORE.name, None, 0), Self::add_explore)
    }

    fn add_explore(&mut self) -> Added<Transitions> {
        let (model, options, step_s) = (self.parts.model.clone(), self.spec.explore, self.step_s());
        let seed = self.seed.child("explore");
        let params = (model.clone(), options, step_s, seed.0);
        self.graph.stage(EXPLORE, self.label("exploration"), &params, &[], move |_| {
            let mut plant = model.build(&[], step_s)?;
            tasks::explore(plant.as_mut(), &options, seed).map_err(status)
        })
    }

    /// The same commands on the robot.
    pub(crate) fn replay(&mut self) -> Added<Transitions> {
        self.once((REPLAY.name, None, 0), Self::add_replay)
    }

    fn add_replay(&mut self) -> Added<Transitions> {
        let explored = self.explore()?;
        let (plant, step_s, seed) = (self.parts.plant.clone(), self.step_s(), self.seed.child("replay"));
        let params = (plant.clone(), step_s, seed.0);
        self.graph.stage(REPLAY, self.label("replay"), &params, &[explored.number()], move |given| {
            let mut plant = plant.build(&[], step_s)?;
            tasks::replay(plant.as_mut(), given.get(explored)?, seed).map_err(status)
        })
    }

    /// Model and robot side by side, `rows` samples spread over the exploration; the rows' seed is filled in by whoever publishes them.
    pub(crate) fn gap(&mut self, rows: usize) -> Added<Vec<GapRow>> {
        let (explored, replayed) = (self.explore()?, self.replay()?);
        let inputs = [explored.number(), replayed.number()];
        self.graph.stage(GAP, self.label("gap"), &rows, &inputs, move |given| {
            let (model, robot) = (given.get(explored)?, given.get(replayed)?);
            if model.pulls_m.width() != 4 {
                return Err(format!("{} tendons, the table has 4", model.pulls_m.width()));
            }
            let rows = rows.min(model.len());
            Ok((0..rows).map(|row| gap_row(model, robot, row * model.len() / rows)).collect())
        })
    }

    /// The predefined points of the Gaussian process, on model and robot.
    pub(crate) fn gp_pool(&mut self) -> Added<GpPool> {
        self.once((GP_POOL.name, None, 0), Self::add_gp_pool)
    }

    fn add_gp_pool(&mut self) -> Added<GpPool> {
        let (model, robot, mut options) = (self.parts.model.clone(), self.parts.plant.clone(), self.spec.gp_points);
        options.p_sim = SimulatedBy::Rod; // the recording is the same whatever p_sim is later taken from
        let (step_s, seed) = (self.step_s(), self.seed.child("gp_pool"));
        let params = (model.clone(), robot.clone(), options, step_s, seed.0);
        self.graph.stage(GP_POOL, self.label("predefined points"), &params, &[], move |_| {
            let (mut model, mut robot) = (model.build(&[], step_s)?, robot.build(&[], step_s)?);
            tasks::gp_points(model.as_mut(), robot.as_mut(), &options, seed).map_err(status)
        })
    }

    /// All points that may become targets: of the robot without measurement noise, the same for every seed.
    fn target_pool(&mut self) -> Added<Vec<Point3>> {
        let (robot, step_s) = (self.parts.quiet.clone(), self.step_s());
        let mut options = self.spec.targets;
        options.drawn = 1; // how many are drawn later does not change the pool
        self.graph.stage(TARGET_POOL, "target pool", &(robot.clone(), options, step_s), &[], move |_| {
            let mut robot = robot.build(&[], step_s)?;
            tasks::target_pool(robot.as_mut(), &options, Seed(0)).map_err(status)
        })
    }

    /// The targets of this repetition: of no policy's choosing, so that every policy meets the same.
    pub(crate) fn targets(&mut self) -> Added<Targets> {
        self.once((TARGETS.name, None, 0), Self::add_targets)
    }

    fn add_targets(&mut self) -> Added<Targets> {
        let pool = self.target_pool()?;
        let (drawn, seed) = (self.spec.targets.drawn, self.seed.child("targets"));
        self.graph.stage(TARGETS, self.label("targets"), &(drawn, seed.0), &[pool.number()], move |given| {
            tasks::draw_targets(given.get(pool)?, drawn, seed).map_err(status)
        })
    }

    /// The points through which the path goes: of the robot without measurement noise, the same for every seed.
    pub(crate) fn waypoints(&mut self) -> Added<Vec<Point3>> {
        let (robot, step_s) = (self.parts.quiet.clone(), self.step_s());
        let options = self.spec.path;
        self.graph.stage(WAYPOINTS, "way-points", &(robot.clone(), options, step_s), &[], move |_| {
            let mut robot = robot.build(&[], step_s)?;
            tasks::waypoints(robot.as_mut(), &options, Seed(0)).map_err(status)
        })
    }

    /// The path that is tracked.
    pub(crate) fn path(&mut self) -> Added<Vec<Point3>> {
        self.once((PATH.name, None, 0), Self::add_path)
    }

    fn add_path(&mut self) -> Added<Vec<Point3>> {
        let (waypoints, options) = (self.waypoints()?, self.spec.path);
        self.graph.stage(PATH, "path", &options, &[waypoints.number()], move |given| {
            tasks::interpolate(given.get(waypoints)?, &options).map_err(status)
        })
    }
}

fn gap_row(model: &Transitions, robot: &Transitions, sample: usize) -> GapRow {
    let (pulls, sim, real) = (model.pulls_m.row(sample), model.to_m.row(sample), robot.to_m.row(sample));
    GapRow {
        seed: 0,
        sample: sample as u64,
        tendon_1_m: pulls[0],
        tendon_2_m: pulls[1],
        tendon_3_m: pulls[2],
        tendon_4_m: pulls[3],
        sim_x_m: sim[0],
        sim_y_m: sim[1],
        sim_z_m: sim[2],
        real_x_m: real[0],
        real_y_m: real[1],
        real_z_m: real[2],
    }
}
