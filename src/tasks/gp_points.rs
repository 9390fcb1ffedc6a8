//! The predefined points of the error model (section IV-B): "1000 real points across workspace", and the sparse
//! choice of one point of each cluster of consecutive ones.

use rand::RngExt;
use serde::{Deserialize, Serialize};

use super::actuation::{Bend, GridOptions, bend_commands, check_pairs, drive_to};
use super::explore::{ExploreOptions, explore_trajectory};
use super::{Samples, TaskError};
use crate::base::{BadOption, Observation, Plant, Rows, Seed, TendonCommand};

/// How the predefined points lie in the workspace.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Layout {
    /// A serpentine over the actuation plane, one point a grid node, visited in order.
    #[default]
    Grid,
    /// Steps of a random exploration of its own.
    Walk,
}

/// Points of a random exploration: every `every`-th step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WalkOptions {
    /// Points kept.
    pub points: usize,
    /// Steps from one kept point to the next.
    pub every: usize,
    /// Largest change of an actuated tendon in a step.
    pub max_step_m: f64,
    /// Largest pull.
    pub max_pull_m: f64,
}

impl Default for WalkOptions {
    fn default() -> Self {
        WalkOptions { points: 1_000, every: 10, max_step_m: 0.003, max_pull_m: 0.03 }
    }
}

impl WalkOptions {
    fn exploration(&self) -> ExploreOptions {
        let points = self.points.saturating_mul(self.every);
        ExploreOptions { points, trajectories: 1, max_step_m: self.max_step_m, max_pull_m: self.max_pull_m }
    }
}

/// Settings of the predefined points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GpPointsOptions {
    /// How they lie in the workspace.
    pub layout: Layout,
    /// The nodes, for [`Layout::Grid`].
    pub grid: GridOptions,
    /// The steps, for [`Layout::Walk`].
    pub walk: WalkOptions,
    /// Further steps for which a node's command is held before it is measured (grid only).
    pub hold_steps: usize,
}

impl GpPointsOptions {
    /// Number of points.
    pub fn points(&self) -> usize {
        match self.layout {
            Layout::Grid => self.grid.rows * self.grid.columns,
            Layout::Walk => self.walk.points,
        }
    }

    /// Checks every range.
    ///
    /// # Errors
    /// [`BadOption`] names the first field out of range.
    pub fn check(&self) -> Result<(), BadOption> {
        self.grid.check()?;
        BadOption::unless_counted("every", self.walk.every)?;
        self.walk.exploration().check()
    }
}

/// The same commands on model and robot: what eq. (20) is fitted to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GpPoints {
    /// Displacements (metres) and simulated tip (metres): (L_1 … L_4, p_sim), seven columns.
    pub inputs: Rows,
    /// Measured tip p_exp, metres, three columns.
    pub real_m: Rows,
    /// The gap p_sim − p_exp, metres, three columns.
    pub errors_m: Rows,
}

impl GpPoints {
    /// The points with these indices.
    pub fn select(&self, indices: &[usize]) -> GpPoints {
        GpPoints {
            inputs: self.inputs.select(indices),
            real_m: self.real_m.select(indices),
            errors_m: self.errors_m.select(indices),
        }
    }
}

/// A model's recording of the predefined points: every step with its command, and which steps are the points.
struct Visited {
    steps: Samples,
    kept: Vec<usize>,
}

/// Records the predefined points on the model and replays them on the robot.
///
/// # Errors
/// [`TaskError`] for a setting out of range or a plant that fails.
pub fn gp_points(
    model: &mut dyn Plant,
    robot: &mut dyn Plant,
    options: &GpPointsOptions,
    seed: Seed,
) -> Result<GpPoints, TaskError> {
    options.check()?;
    let seed = seed.child("gp_points");
    let visited = match options.layout {
        Layout::Grid => visit_grid(model, &options.grid, options.hold_steps, seed)?,
        Layout::Walk => {
            let WalkOptions { points, every, .. } = options.walk;
            let steps = explore_trajectory(model, &options.walk.exploration(), seed, 0)?;
            Visited { steps, kept: (0..points).map(|point| point * every + every / 2).collect() }
        }
    };
    let mut points = GpPoints { inputs: Rows::new(7), real_m: Rows::new(3), errors_m: Rows::new(3) };
    robot.reset(seed.child("robot"))?;
    let mut kept = visited.kept.iter().copied().peekable();
    for row in 0..visited.steps.len() {
        let pulls_m = visited.steps.pulls_m.row(row);
        let seen = robot.step(pulls_m)?;
        if kept.next_if_eq(&row).is_some() {
            let simulated_m = visited.steps.to_m.row(row);
            points.inputs.push(&[pulls_m, simulated_m].concat());
            points.real_m.push(&seen.tip_m);
            let error_m: Vec<f64> = simulated_m.iter().zip(seen.tip_m).map(|(sim, real)| sim - real).collect();
            points.errors_m.push(&error_m);
        }
    }
    Ok(points)
}

fn visit_grid(model: &mut dyn Plant, grid: &GridOptions, hold_steps: usize, seed: Seed) -> Result<Visited, TaskError> {
    check_pairs(model)?;
    let start = model.reset(seed.child("model"))?;
    let mut recorder = Recorder { plant: model, tip_m: start.tip_m, steps: Samples::begin(4) };
    let mut bend_m: Bend = [0.0; 2];
    let mut kept = Vec::with_capacity(grid.rows * grid.columns);
    for point_m in grid.points_m() {
        let moved = drive_to(&mut recorder, &mut bend_m, point_m, grid.max_step_m)?;
        // A point on which the robot already stands is measured after a step on the spot.
        for _ in 0..hold_steps + usize::from(moved.is_none()) {
            recorder.drive(&bend_commands(bend_m))?;
        }
        kept.push(recorder.steps.len() - 1);
    }
    Ok(Visited { steps: recorder.steps, kept })
}

/// A plant that keeps what was done with it.
struct Recorder<'a> {
    plant: &'a mut dyn Plant,
    tip_m: crate::base::Point3,
    steps: Samples,
}

impl Plant for Recorder<'_> {
    fn tendons(&self) -> usize {
        self.plant.tendons()
    }

    fn step_s(&self) -> f64 {
        self.plant.step_s()
    }

    fn reset(&mut self, seed: Seed) -> Result<Observation, crate::base::PlantError> {
        self.steps = Samples::begin(self.plant.tendons());
        let seen = self.plant.reset(seed)?;
        self.tip_m = seen.tip_m;
        Ok(seen)
    }

    fn drive(&mut self, commands: &[TendonCommand]) -> Result<Observation, crate::base::PlantError> {
        let seen = self.plant.drive(commands)?;
        self.steps.push(&self.tip_m, &seen);
        self.tip_m = seen.tip_m;
        Ok(seen)
    }
}

/// The sparse choice: `total` consecutive points are divided into `count` clusters as equal as they come (boundaries
/// at ⌊i·total/count⌋) and one point is drawn of each, in the order of the points.
///
/// # Errors
/// [`TaskError::TooFew`] when more points are asked for than there are, [`TaskError::Option`] when none is.
pub fn one_of_each_cluster(total: usize, count: usize, seed: Seed) -> Result<Vec<usize>, TaskError> {
    BadOption::unless_counted("count", count)?;
    if count > total {
        return Err(TaskError::TooFew { what: "points of the error model", asked: count, available: total });
    }
    let mut random = seed.child("clusters").index(count as u64).rng();
    let edge = |cluster: usize| cluster * total / count;
    Ok((0..count).map(|cluster| random.random_range(edge(cluster)..edge(cluster + 1))).collect())
}
