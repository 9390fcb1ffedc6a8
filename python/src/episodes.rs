//! Episodes of an environment: what an action moves, what a step is worth, and when it ends. The
//! arithmetic of one robot; `robots.rs` steps many.

use pyo3::prelude::*;
use spinebench::base::TendonLayout;

use crate::errors::Fault;
use crate::plants::{OK, Robot};

/// How actions become displacements.
pub(crate) struct Drive {
    /// What each component of an action does to each tendon.
    ways: Vec<Vec<f64>>,
    tendons: usize,
    pub(crate) travel_m: f64,
    pub(crate) max_step_m: f64,
}

impl Drive {
    /// Actions that bend each segment in two directions, or pull each tendon.
    pub(crate) fn new(
        action: &str,
        layout: TendonLayout,
        tendons: usize,
        travel_m: f64,
        max_step_m: f64,
    ) -> Result<Drive, Fault> {
        let one = |tendon: usize| {
            let mut row = vec![0.0; tendons];
            row[tendon] = 1.0;
            row
        };
        let ways = match action {
            "tendons" => (0..tendons).map(one).collect(),
            "bend" => layout
                .segments
                .iter()
                .flat_map(|segment| {
                    [f64::cos, f64::sin].map(|turn| {
                        let mut row = vec![0.0; tendons];
                        for placed in segment {
                            row[placed.tendon] = turn(placed.angle_deg.to_radians());
                        }
                        row
                    })
                })
                .collect(),
            other => {
                let expected = "\"bend\" or \"tendons\"";
                return Err(Fault::argument("action", format!("'{other}'"), expected));
            }
        };
        Ok(Drive { ways, tendons, travel_m, max_step_m })
    }

    /// Number of components of an action.
    pub(crate) fn actions(&self) -> usize {
        self.ways.len()
    }

    pub(crate) fn tendons(&self) -> usize {
        self.tendons
    }

    /// Moves what is wanted by an action and returns the displacements, metres.
    fn pulls_m(&self, wanted_m: &mut [f64], action: &[f64]) -> Vec<f64> {
        let held = |value: f64| value.clamp(-self.travel_m, self.travel_m);
        let mut pulls_m = vec![0.0; self.tendons];
        for ((wanted_m, action), way) in wanted_m.iter_mut().zip(action).zip(&self.ways) {
            *wanted_m = held(*wanted_m + self.max_step_m * action.clamp(-1.0, 1.0));
            pulls_m.iter_mut().zip(way).for_each(|(pull_m, share)| *pull_m += *wanted_m * share);
        }
        pulls_m.iter_mut().for_each(|pull_m| *pull_m = held(*pull_m));
        pulls_m
    }
}

/// What is asked of a robot.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Task {
    /// Unit of positions in observations, metres.
    scale_m: f64,
    /// Largest coordinate of an observed position in this unit.
    limit: f64,
    /// Targets one after the other, metres; without them a target holds for an episode.
    path_m: Option<Vec<[f64; 3]>>,
    max_steps: u64,
    within_m: Option<f64>,
    hold_steps: u64,
    /// The reward: 1 within `within_m`; otherwise the distance in this unit, negative.
    is_sparse: bool,
}

/// One robot in its episode.
pub(crate) struct Episode {
    pub(crate) robot: Robot,
    /// Wanted bends or displacements, metres.
    pub(crate) wanted_m: Vec<f64>,
    pub(crate) target_m: [f64; 3],
    steps: u64,
    held: u64,
    pub(crate) has_ended: bool,
    pub(crate) step: Step,
}

/// What came of the last step.
#[derive(Clone, Copy, Default)]
pub(crate) struct Step {
    /// The target of the step, metres.
    pub(crate) target_m: [f64; 3],
    /// Distance of the tip from it, metres.
    pub(crate) distance_m: f64,
    pub(crate) reward: f64,
    pub(crate) is_terminated: bool,
    pub(crate) is_truncated: bool,
}

impl Episode {
    pub(crate) fn new(robot: Robot, drive: &Drive) -> Episode {
        let wanted_m = vec![0.0; drive.actions()];
        let (target_m, step) = ([0.0; 3], Step::default());
        Episode { robot, wanted_m, target_m, steps: 0, held: 0, has_ended: true, step }
    }

    /// Begins anew with the robot as it was reset.
    pub(crate) fn begin(&mut self, target_m: [f64; 3]) {
        self.wanted_m.fill(0.0);
        (self.target_m, self.steps, self.held, self.has_ended) = (target_m, 0, 0, false);
        let distance_m = distance_m(self.robot.tip_m(), target_m);
        self.step = Step { target_m, distance_m, ..Step::default() };
    }

    /// Moves the robot alone.
    pub(crate) fn drive(&mut self, action: &[f64], drive: &Drive) {
        let pulls_m = drive.pulls_m(&mut self.wanted_m, action);
        self.robot.step(&pulls_m);
    }

    /// One step.
    pub(crate) fn step(&mut self, action: &[f64], drive: &Drive, task: &Task) {
        self.drive(action, drive);
        let target_m = self.target_m;
        let distance_m = distance_m(self.robot.tip_m(), target_m);
        let has_failed = self.robot.status != OK;
        let is_within = task.within_m.is_some_and(|within_m| distance_m <= within_m);
        self.steps += 1;
        self.held = if is_within { self.held + 1 } else { 0 };
        let reward = match (has_failed, task.is_sparse) {
            (true, _) => -1.0,
            (false, true) => f64::from(u8::from(is_within)),
            (false, false) => -distance_m / task.scale_m,
        };
        let is_reached = task.path_m.is_none() && self.held >= task.hold_steps;
        let is_terminated = has_failed || is_reached;
        let is_truncated = self.steps >= task.max_steps && !is_terminated;
        if let Some(path_m) = &task.path_m {
            let place = (self.steps as usize).min(path_m.len() - 1);
            self.target_m = path_m[place];
        }
        self.has_ended = is_terminated || is_truncated;
        self.step = Step { target_m, distance_m, reward, is_terminated, is_truncated };
    }

    /// Tip, target, target minus tip, each in the unit of the task and within its limit (a tip that
    /// was never seen counts as 0), and what is wanted as shares of the travel.
    pub(crate) fn observe(&self, drive: &Drive, task: &Task) -> impl Iterator<Item = f32> {
        let (tip_m, target_m) = (self.robot.tip_m(), self.target_m);
        let shown = |position_m: f64| {
            if position_m.is_nan() {
                return 0.0;
            }
            (position_m / task.scale_m).clamp(-task.limit, task.limit)
        };
        let tip = tip_m.map(shown);
        let target = target_m.map(shown);
        let between: [f64; 3] = std::array::from_fn(|axis| target[axis] - tip[axis]);
        let wanted = self.wanted_m.iter().map(|wanted_m| wanted_m / drive.travel_m);
        tip.into_iter().chain(target).chain(between).chain(wanted).map(|value| value as f32)
    }
}

/// Numbers of an observation.
pub(crate) fn observation_size(drive: &Drive) -> usize {
    9 + drive.actions()
}

fn distance_m(tip_m: [f64; 3], target_m: [f64; 3]) -> f64 {
    let squares = (0..3).map(|axis| (tip_m[axis] - target_m[axis]).powi(2));
    squares.sum::<f64>().sqrt()
}
