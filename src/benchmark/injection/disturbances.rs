//! Disturbances outside the catalogue: changes of the commands before the drives, or of the tip
//! before the recording.

use nalgebra::Vector3;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use crate::base::{Generator, Point3, Rows};
use crate::benchmark::commands::Commands;
use crate::math::rotation;

/// A kind of disturbance.
#[derive(Clone, Copy, Debug)]
pub struct DisturbanceKind {
    /// Its name.
    pub name: &'static str,
    /// Description.
    pub what: &'static str,
    /// Usual size, in metres, radians or shares.
    pub size: f64,
    /// Maximum multiple of the usual size.
    pub max_multiple: f64,
    act: DisturbanceAction,
}

/// Where a disturbance acts: on drive positions (rows of a trial), or on one tip sample.
#[derive(Clone, Copy, Debug)]
enum DisturbanceAction {
    Drives(fn(&Disturbance, &[f64], TrialProgress) -> Vec<f64>),
    Tip(fn(&Disturbance, Vector3<f64>, TrialProgress) -> Vector3<f64>),
}

/// Elapsed share of a trial.
#[derive(Clone, Copy, Debug)]
struct TrialProgress {
    share: f64,
}

/// A disturbance with its values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Disturbance {
    /// Name in [`DISTURBANCES`].
    pub name: String,
    /// Size, in the unit of its kind.
    pub size: f64,
    /// Index of its tendon.
    pub tendon: usize,
    /// Unit direction.
    pub direction: Point3,
    /// Relative position in its range, 0 to 1.
    pub place: f64,
}

impl Disturbance {
    /// One of which nothing but the name is known.
    pub(crate) fn named(name: &str) -> Disturbance {
        Disturbance {
            name: name.to_owned(),
            size: f64::NAN,
            tendon: 0,
            direction: [f64::NAN; 3],
            place: f64::NAN,
        }
    }
}

/// All kinds.
pub const DISTURBANCES: &[DisturbanceKind] = &[
    DisturbanceKind {
        name: "step_loss",
        what: "a motor loses steps once in every trial; its tendon is released by a constant \
               length from then on",
        size: 1e-3,
        max_multiple: 10.0,
        act: DisturbanceAction::Drives(step_loss),
    },
    DisturbanceKind {
        name: "dead_zone",
        what: "drives have a static dead zone about home",
        size: 1e-3,
        max_multiple: 10.0,
        act: DisturbanceAction::Drives(dead_zone),
    },
    DisturbanceKind {
        name: "sign_gain",
        what: "a drive releases its tendon by less than commanded and pulls it as commanded",
        size: 0.1,
        max_multiple: 8.0,
        act: DisturbanceAction::Drives(sign_gain),
    },
    DisturbanceKind {
        name: "screw_error",
        what: "lead screws with a periodic error of 8 mm pitch",
        size: 5e-4,
        max_multiple: 6.0,
        act: DisturbanceAction::Drives(screw_error),
    },
    DisturbanceKind {
        name: "frame_drift",
        what: "the tracking frame drifts during a trial",
        size: 2e-3,
        max_multiple: 20.0,
        act: DisturbanceAction::Tip(frame_drift),
    },
    DisturbanceKind {
        name: "frame_bump",
        what: "the tracking frame shifts once in every trial",
        size: 2e-3,
        max_multiple: 20.0,
        act: DisturbanceAction::Tip(frame_bump),
    },
    DisturbanceKind {
        name: "frame_rotation",
        what: "the tracking frame is rotated relative to gravity",
        size: 0.01,
        max_multiple: 20.0,
        act: DisturbanceAction::Tip(frame_rotation),
    },
    DisturbanceKind {
        name: "tracker_scale",
        what: "the tracker's lengths have a scale error",
        size: 0.01,
        max_multiple: 20.0,
        act: DisturbanceAction::Tip(tracker_scale),
    },
    DisturbanceKind {
        name: "loose_base",
        what: "a loose base tilts with the moment of the robot's weight about it",
        size: 0.02,
        max_multiple: 20.0,
        act: DisturbanceAction::Tip(loose_base),
    },
    DisturbanceKind {
        name: "soft_wall",
        what: "an elastic wall next to the robot pushes the tip back",
        size: 0.1,
        max_multiple: 9.0,
        act: DisturbanceAction::Tip(soft_wall),
    },
];

fn step_loss(disturbance: &Disturbance, pulls_m: &[f64], progress: TrialProgress) -> Vec<f64> {
    let mut drives_m = pulls_m.to_vec();
    if progress.share >= 0.2 + 0.5 * disturbance.place {
        drives_m[disturbance.tendon] -= disturbance.size;
    }
    drives_m
}

fn dead_zone(disturbance: &Disturbance, pulls_m: &[f64], _: TrialProgress) -> Vec<f64> {
    pulls_m.iter().map(|pull| pull.signum() * (pull.abs() - disturbance.size).max(0.0)).collect()
}

fn sign_gain(disturbance: &Disturbance, pulls_m: &[f64], _: TrialProgress) -> Vec<f64> {
    let mut drives_m = pulls_m.to_vec();
    if drives_m[disturbance.tendon] < 0.0 {
        drives_m[disturbance.tendon] *= 1.0 - disturbance.size;
    }
    drives_m
}

fn screw_error(disturbance: &Disturbance, pulls_m: &[f64], _: TrialProgress) -> Vec<f64> {
    const PITCH_M: f64 = 0.008;
    let phase = std::f64::consts::TAU * disturbance.place;
    let error = |pull: f64| {
        disturbance.size * ((std::f64::consts::TAU * pull / PITCH_M + phase).sin() - phase.sin())
    };
    pulls_m.iter().map(|&pull| pull + error(pull)).collect()
}

fn frame_drift(
    disturbance: &Disturbance,
    tip_m: Vector3<f64>,
    progress: TrialProgress,
) -> Vector3<f64> {
    tip_m + Vector3::from(disturbance.direction) * (disturbance.size * progress.share)
}

fn frame_bump(
    disturbance: &Disturbance,
    tip_m: Vector3<f64>,
    progress: TrialProgress,
) -> Vector3<f64> {
    let pushed = progress.share >= 0.2 + 0.6 * disturbance.place;
    if pushed { tip_m + Vector3::from(disturbance.direction) * disturbance.size } else { tip_m }
}

fn frame_rotation(
    disturbance: &Disturbance,
    tip_m: Vector3<f64>,
    _: TrialProgress,
) -> Vector3<f64> {
    rotation::exp(&(Vector3::from(disturbance.direction) * disturbance.size)) * tip_m
}

fn tracker_scale(disturbance: &Disturbance, tip_m: Vector3<f64>, _: TrialProgress) -> Vector3<f64> {
    tip_m * (1.0 + disturbance.size)
}

fn loose_base(disturbance: &Disturbance, tip_m: Vector3<f64>, _: TrialProgress) -> Vector3<f64> {
    // x points up. Moment of the weight over that of the horizontal robot.
    let moment = tip_m.cross(&-Vector3::x()) / tip_m.norm().max(1e-9);
    rotation::exp(&(moment * disturbance.size)) * tip_m
}

fn soft_wall(disturbance: &Disturbance, tip_m: Vector3<f64>, _: TrialProgress) -> Vector3<f64> {
    let [x, y, _] = disturbance.direction;
    let normal = Vector3::new(x, y, 0.0) / (x * x + y * y).sqrt().max(1e-9);
    let beyond_m = normal.dot(&tip_m) - 0.03 * disturbance.place;
    tip_m - normal * (disturbance.size * beyond_m.max(0.0))
}

impl DisturbanceKind {
    /// Draws the open values at the usual size.
    pub(crate) fn draw(&self, tendons: usize, random: &mut Generator) -> Disturbance {
        let direction: [f64; 3] = std::array::from_fn(|_| StandardNormal.sample(random));
        let length = Vector3::from(direction).norm().max(1e-9);
        Disturbance {
            name: self.name.to_owned(),
            size: self.size,
            tendon: random.random_range(0..tendons),
            direction: direction.map(|x| x / length),
            place: random.random_range(0.0..1.0),
        }
    }
}

impl Disturbance {
    fn act(&self) -> Option<DisturbanceAction> {
        DISTURBANCES.iter().find(|unknown| unknown.name == self.name).map(|unknown| unknown.act)
    }

    /// The disturbance with `amount` times the size.
    pub(crate) fn scaled(&self, amount: f64) -> Disturbance {
        Disturbance { size: self.size * amount, ..self.clone() }
    }

    /// Drive positions under `commands`.
    pub(crate) fn drives(&self, commands: &Commands) -> Commands {
        let Some(DisturbanceAction::Drives(act)) = self.act() else { return commands.clone() };
        let trial = |commanded: &Rows| {
            let mut rows = Rows::new(commanded.width());
            commanded.iter().enumerate().for_each(|(row, pulls)| {
                rows.push(&act(self, pulls, TrialProgress::new(row, commanded.len())))
            });
            rows
        };
        Commands { step_s: commands.step_s, trials: commands.trials.iter().map(trial).collect() }
    }

    /// Recorded tip by sample.
    pub(crate) fn recorded(&self, commands: &Commands, tips_m: Vec<Point3>) -> Vec<Point3> {
        let Some(DisturbanceAction::Tip(act)) = self.act() else { return tips_m };
        let progress = commands
            .trials
            .iter()
            .flat_map(|trial| (0..trial.len()).map(|row| TrialProgress::new(row, trial.len())));
        let recorded = |(tip, progress): (Point3, TrialProgress)| {
            act(self, Vector3::from(tip), progress).into()
        };
        tips_m.into_iter().zip(progress).map(recorded).collect()
    }
}

impl TrialProgress {
    fn new(row: usize, rows: usize) -> TrialProgress {
        TrialProgress { share: row as f64 / rows.max(1) as f64 }
    }
}
