//! The predefined points of the error model (section IV-B): "1000 real points across workspace".

use serde::{Deserialize, Serialize};

use super::actuation::{BendMap, GridOptions, drive_to};
use super::explore::{ExploreOptions, explore_trajectory};
use super::retry_lost_frames::RetryLostFrames;
use crate::base::{BadOption, Observation, Plant, Rows, Seed, TendonCommand};
use crate::tasks::{TaskError, Transitions};

/// Distribution of the predefined points over the workspace.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PointLayout {
    /// A serpentine over the actuation plane, one point for each grid node, in order.
    Grid(GridOptions),
    /// Every `every`-th step of a separate random exploration.
    Walk {
        /// Number of points.
        points: usize,
        /// Steps from one point to the next.
        every: usize,
        /// Largest change of an actuated tendon in a step.
        #[serde(default = "max_step_m")]
        max_step_m: f64,
        /// Largest pull.
        #[serde(default = "max_pull_m")]
        max_pull_m: f64,
    },
}

fn max_step_m() -> f64 {
    ExploreOptions::default().max_step_m
}

fn max_pull_m() -> f64 {
    ExploreOptions::default().max_pull_m
}

/// Source of p_sim in eq. (20), which "could either generated from our learned dynamic neural
/// network or directly from simulated mathematical model".
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum SimulatedBy {
    /// The rod model, the paper's "preferred choice".
    #[default]
    Rod,
    /// The forward network of eq. (17), run freely over the points' commands.
    Network,
}

/// Settings of the predefined points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GpPointsOptions {
    /// Distribution over the workspace.
    pub layout: PointLayout,
    /// Further steps for which a point's command is held before it is measured (grid only).
    pub hold_steps: usize,
    /// Source of p_sim.
    pub p_sim: SimulatedBy,
}

impl Default for GpPointsOptions {
    fn default() -> Self {
        GpPointsOptions {
            layout: PointLayout::Grid(GridOptions::default()),
            hold_steps: 0,
            p_sim: SimulatedBy::Rod,
        }
    }
}

impl GpPointsOptions {
    /// Number of points.
    pub fn points(&self) -> usize {
        match self.layout {
            PointLayout::Grid(grid) => grid.rows * grid.columns,
            PointLayout::Walk { points, .. } => points,
        }
    }

    /// Checks every range.
    ///
    /// # Errors
    /// [`BadOption`] names the first field out of range.
    pub fn check(&self) -> Result<(), BadOption> {
        match self.layout {
            PointLayout::Grid(grid) => grid.check(),
            PointLayout::Walk { points, every, max_step_m, max_pull_m } => {
                BadOption::unless_counted("every", every)?;
                ExploreOptions { points, trajectories: 1, max_step_m, max_pull_m }.check()
            }
        }
    }
}

/// The recording behind the predefined points, on model and robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GpPool {
    /// Every step of the model, including those between the points.
    pub steps: Transitions,
    /// Indices of the steps that end on a point.
    pub kept: Vec<usize>,
    /// Measured tip p_exp at each point, metres, three columns.
    pub real_m: Rows,
}

impl GpPool {
    /// The points with p_sim from the recorded rod model.
    pub fn points(&self) -> GpPoints {
        self.points_by(&self.steps)
    }

    /// The points with p_sim from `simulated`, the response of another model to the same commands.
    pub fn points_by(&self, simulated: &Transitions) -> GpPoints {
        let mut points = GpPoints::none(simulated.pulls_m.width());
        for (&step, real_m) in self.kept.iter().zip(self.real_m.iter()) {
            points.push(simulated, step, real_m);
        }
        points
    }

    /// The points as they would be on a robot that differs from the measured one as `changed`, the
    /// response of a changed model to the same commands, differs from the recorded model.
    pub fn moved(&self, changed: &Transitions) -> GpPoints {
        let mut points = GpPoints::none(self.steps.pulls_m.width());
        for (&step, real_m) in self.kept.iter().zip(self.real_m.iter()) {
            let (from_m, to_m) = (self.steps.to_m.row(step), changed.to_m.row(step));
            // Measurement plus the change that the model predicts keeps gap and noise of the robot.
            let moved_m: Vec<f64> =
                (0..3).map(|axis| real_m[axis] + to_m[axis] - from_m[axis]).collect();
            points.push(&self.steps, step, &moved_m);
        }
        points
    }
}

/// The training data of eq. (20): the same commands on model and robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GpPoints {
    /// Displacements (metres) and simulated tip (metres): (L_1 … L_n, p_sim), three columns more
    /// than tendons.
    pub inputs: Rows,
    /// Measured tip p_exp, metres, three columns.
    pub real_m: Rows,
    /// The gap p_sim − p_exp, metres, three columns.
    pub errors_m: Rows,
}

impl GpPoints {
    fn none(tendons: usize) -> GpPoints {
        GpPoints { inputs: Rows::new(tendons + 3), real_m: Rows::new(3), errors_m: Rows::new(3) }
    }

    /// Appends step `index` of a model beside the tip measured after it, metres.
    fn push(&mut self, simulated: &Transitions, index: usize, real_m: &[f64]) {
        let simulated_m = simulated.to_m.row(index);
        self.inputs.push(&[simulated.pulls_m.row(index), simulated_m].concat());
        self.real_m.push(real_m);
        let error_m: Vec<f64> =
            simulated_m.iter().zip(real_m).map(|(sim, real)| sim - real).collect();
        self.errors_m.push(&error_m);
    }

    /// Appends every step of a recording, `simulated` by a model under the same commands.
    pub fn extend(&mut self, simulated: &Transitions, measured: &Transitions) {
        for (index, real_m) in measured.to_m.iter().enumerate() {
            self.push(simulated, index, real_m);
        }
    }

    /// The points with these indices.
    pub fn select(&self, indices: &[usize]) -> GpPoints {
        GpPoints {
            inputs: self.inputs.select(indices),
            real_m: self.real_m.select(indices),
            errors_m: self.errors_m.select(indices),
        }
    }
}

/// A model's recording of the predefined points: every step with its command, and the indices of
/// the points.
struct Visited {
    steps: Transitions,
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
) -> Result<GpPool, TaskError> {
    options.check()?;
    let seed = seed.child("gp_points");
    let visited = match options.layout {
        PointLayout::Grid(grid) => visit_grid(model, &grid, options.hold_steps, seed)?,
        PointLayout::Walk { points, every, max_step_m, max_pull_m } => {
            let walk =
                ExploreOptions { points: points * every, trajectories: 1, max_step_m, max_pull_m };
            let steps = explore_trajectory(model, &walk, seed, 0)?;
            // The middle of each stretch of `every` steps.
            Visited { steps, kept: (0..points).map(|point| point * every + every / 2).collect() }
        }
    };
    let mut real_m = Rows::new(3);
    let mut robot = RetryLostFrames(robot);
    robot.reset(seed.child("robot"))?;
    let mut kept = visited.kept.iter().copied().peekable();
    // Every step is replayed, points or not: the robot's history must be the model's.
    for row in 0..visited.steps.len() {
        let pulls_m = visited.steps.pulls_m.row(row);
        let observation = robot.step(pulls_m)?;
        if kept.next_if_eq(&row).is_some() {
            real_m.push(&observation.tip_m);
        }
    }
    robot.verify()?;
    Ok(GpPool { steps: visited.steps, kept: visited.kept, real_m })
}

fn visit_grid(
    model: &mut dyn Plant,
    grid: &GridOptions,
    hold_steps: usize,
    seed: Seed,
) -> Result<Visited, TaskError> {
    let map = BendMap::of(model)?;
    let tendons = model.tendons();
    let mut model = RetryLostFrames(model);
    let start = model.reset(seed.child("model"))?;
    let mut recorder =
        Recorder { plant: &mut model, tip_m: start.tip_m, steps: Transitions::begin(tendons) };
    let mut bend_m = map.straight();
    let mut kept = Vec::with_capacity(grid.rows * grid.columns);
    for point_m in grid.bends_m(&map) {
        let moved = drive_to(&mut recorder, &map, &mut bend_m, point_m, grid.max_step_m)?;
        // A point at which the robot already is gets one step in place before it is measured.
        for _ in 0..hold_steps + usize::from(moved.is_none()) {
            recorder.drive(&map.commands(&bend_m))?;
        }
        kept.push(recorder.steps.len() - 1);
    }
    Ok(Visited { steps: recorder.steps, kept })
}

/// A plant that records its steps.
struct Recorder<'a> {
    plant: &'a mut dyn Plant,
    tip_m: crate::base::Point3,
    steps: Transitions,
}

impl Plant for Recorder<'_> {
    fn tendons(&self) -> usize {
        self.plant.tendons()
    }

    fn step_s(&self) -> f64 {
        self.plant.step_s()
    }

    fn reset(&mut self, seed: Seed) -> Result<Observation, crate::base::PlantError> {
        self.steps = Transitions::begin(self.plant.tendons());
        let observation = self.plant.reset(seed)?;
        self.tip_m = observation.tip_m;
        Ok(observation)
    }

    fn verify(&mut self) -> Result<(), crate::base::PlantError> {
        self.plant.verify()
    }

    fn drive(
        &mut self,
        commands: &[TendonCommand],
    ) -> Result<Observation, crate::base::PlantError> {
        let observation = self.plant.drive(commands)?;
        self.steps.push(&self.tip_m, &observation);
        self.tip_m = observation.tip_m;
        Ok(observation)
    }
}
