//! Displacements and lengths of an experiment, in proportion to its robot.
//!
//! The defaults are those of the paper's robot: 30 mm of travel over levers of 20 mm, 1.5 rad, and
//! steps of a tenth of it. For a robot of other levers or another length they change in proportion.
//! What a spec says beside its robot, or in what extends it, counts as it is; what an extended file
//! says for its own robot is scaled from that one. `travel_m` replaces the travel that follows from
//! the levers, for all sections at once.

use super::spec::Experiment;
use crate::plants::{PlantSpec, RobotSize};
use crate::specs::document::merged::Document;
use crate::specs::document::mismatch::deserialize;
use crate::specs::document::path::KeyPath;
use crate::tasks::PointLayout;

/// Lever and length of the paper's robot, metres, and its travel as an angle.
const PAPER_SIZE: RobotSize = RobotSize { lever_m: 0.02, length_m: 0.22 };
const TRAVEL_RAD: f64 = 1.5;
const PAPER_TRAVEL_M: f64 = 0.03;
/// Bend of a segment beyond which a spec is likely meant for another robot.
const MAX_BEND_RAD: f64 = 2.0;
/// Digits of a number that follows from the robot.
const DIGITS: i32 = 2;

/// The travel that suits a robot, metres: 1.5 rad over its levers, and the paper robot's where they
/// are not told.
pub fn suited_travel_m(size: Option<RobotSize>) -> f64 {
    let lever_m = size.unwrap_or(PAPER_SIZE).lever_m;
    if lever_m == PAPER_SIZE.lever_m { PAPER_TRAVEL_M } else { rounded(TRAVEL_RAD * lever_m) }
}

/// A number of an experiment.
struct Scaled {
    key: &'static str,
    /// For the paper's robot.
    paper: f64,
    number: fn(&mut Experiment) -> Option<&mut f64>,
}

macro_rules! scaled {
    ($($key:literal: $paper:literal, |$spec:ident| $number:expr;)*) => {
        &[$(Scaled { key: $key, paper: $paper, number: |$spec| $number }),*]
    };
}

/// In proportion to the travel.
static DISPLACEMENTS: &[Scaled] = scaled! {
    "explore.max_pull_m": 0.03, |spec| Some(&mut spec.explore.max_pull_m);
    "explore.max_step_m": 0.003, |spec| Some(&mut spec.explore.max_step_m);
    "gp_points.layout.grid.max_pull_m": 0.03, |spec| layout(spec, true).map(|[pull_m, _]| pull_m);
    "gp_points.layout.grid.max_step_m": 0.003, |spec| layout(spec, true).map(|[_, step_m]| step_m);
    "gp_points.layout.walk.max_pull_m": 0.03, |spec| layout(spec, false).map(|[pull_m, _]| pull_m);
    "gp_points.layout.walk.max_step_m": 0.003, |spec| layout(spec, false).map(|[_, step_m]| step_m);
    "targets.sweep.max_pull_m": 0.03, |spec| Some(&mut spec.targets.sweep.max_pull_m);
    "targets.sweep.max_step_m": 0.003, |spec| Some(&mut spec.targets.sweep.max_step_m);
    "path.radius_m": 0.02, |spec| Some(&mut spec.path.radius_m);
    "path.max_step_m": 0.003, |spec| Some(&mut spec.path.max_step_m);
    "policies.limits.travel_m": 0.03, |spec| Some(&mut spec.policies.limits.travel_m);
    "policies.limits.max_step_m": 0.003, |spec| spec.policies.limits.max_step_m.as_mut();
    "policies.mpc.slack_m": 0.003, |spec| Some(&mut spec.policies.mpc.slack_m);
    "policies.mpc.settled_pull_m": 0.0002, |spec| Some(&mut spec.policies.mpc.settled_pull_m);
    "policies.model_integral.slack_m": 0.003, |spec| Some(&mut spec.policies.model_integral.slack_m);
    "policies.online_jacobian.settled_pull_m": 0.0002,
        |spec| Some(&mut spec.policies.online_jacobian.settled_pull_m);
};

/// In proportion to the length of the robot.
static LENGTHS: &[Scaled] = scaled! {
    "policies.a.tolerance_m": 0.001, |spec| Some(&mut spec.policies.a.tolerance_m);
    "policies.c.switch_threshold_m": 0.015, |spec| Some(&mut spec.policies.c.switch_threshold_m);
    "path.spacing_m": 0.002, |spec| Some(&mut spec.path.spacing_m);
};

/// In proportion to how far the tip moves for each metre of displacement.
static GAINS: &[Scaled] = scaled! {
    "policies.online_jacobian.first_gain": 4.0,
        |spec| Some(&mut spec.policies.online_jacobian.first_gain);
    "policies.online_jacobian.first_sd": 2.0,
        |spec| Some(&mut spec.policies.online_jacobian.first_sd);
};

/// In proportion to how much that changes for each metre.
static GAIN_CHANGES: &[Scaled] = scaled! {
    "policies.online_jacobian.drift_per_m": 100.0,
        |spec| Some(&mut spec.policies.online_jacobian.drift_per_m);
};

/// In proportion to the displacement for each metre of the tip.
static INVERSE_GAINS: &[Scaled] = scaled! {
    "policies.integral.gain": 0.05, |spec| Some(&mut spec.policies.integral.gain);
};

/// Largest pull and step of the points, of a grid or of a walk.
fn layout(spec: &mut Experiment, grid: bool) -> Option<[&mut f64; 2]> {
    match &mut spec.gp_points.layout {
        PointLayout::Grid(options) if grid => {
            Some([&mut options.max_pull_m, &mut options.max_step_m])
        }
        PointLayout::Walk { max_pull_m, max_step_m, .. } if !grid => Some([max_pull_m, max_step_m]),
        _ => None,
    }
}

/// How a number follows from the robot.
struct Proportion {
    /// To the number for the paper's robot.
    of_paper: f64,
    /// To the number that an extended file says for its own robot.
    of_inherited: Option<f64>,
    /// Rank of the source that the proportion comes from; stronger ones say their own numbers.
    rank: Option<usize>,
}

/// Gives the numbers that nobody has written for this robot the size that suits it. Returns what
/// the user should know of it.
pub(crate) fn scale(spec: &mut Experiment, document: &Document) -> Vec<String> {
    let size = spec.model.size().unwrap_or(PAPER_SIZE);
    let rank = ["model.simulated.model.robot", "model.constant_curvature"]
        .iter()
        .filter_map(|path| document.rank(&key_path(path)))
        .min();
    let inherited = rank.and_then(|rank| size_below(document, rank)).unwrap_or(PAPER_SIZE);
    let as_robot = |measure: fn(RobotSize) -> f64| Proportion {
        of_paper: measure(size) / measure(PAPER_SIZE),
        of_inherited: Some(measure(size) / measure(inherited)),
        rank,
    };
    let of_levers = as_robot(|size| size.lever_m);
    let of_travel = spec.travel_m.map_or(of_levers, |travel_m| Proportion {
        of_paper: travel_m / PAPER_TRAVEL_M,
        of_inherited: None,
        rank: document.rank(&key_path("travel_m")),
    });
    let mut scaled = of_travel.apply(DISPLACEMENTS, spec, document);
    make_room(spec, document, rounded(of_travel.of_paper * PAPER_TRAVEL_M));
    for (numbers, proportion) in [
        (LENGTHS, as_robot(|size| size.length_m)),
        // How far the tip moves for a displacement, how fast that changes, and its inverse.
        (GAINS, as_robot(|size| size.length_m / size.lever_m)),
        (GAIN_CHANGES, as_robot(|size| size.length_m / size.lever_m.powi(2))),
        (INVERSE_GAINS, as_robot(|size| size.lever_m / size.length_m)),
    ] {
        scaled.extend(proportion.apply(numbers, spec, document));
    }
    if scaled.is_empty() {
        return Vec::new();
    }
    vec![format!(
        "{}: scaled to this robot, because the extended file sets them for another robot: {}",
        spec.name,
        scaled.join(", ")
    )]
}

impl Proportion {
    /// Scales the numbers; returns those of extended files that have changed, with their values.
    fn apply(&self, numbers: &[Scaled], spec: &mut Experiment, document: &Document) -> Vec<String> {
        let mut inherited = Vec::new();
        for Scaled { key, paper, number } in numbers {
            let written = document.rank(&key_path(key));
            if written.is_some_and(|written| self.rank.is_none_or(|rank| written <= rank)) {
                continue;
            }
            let Some(value) = number(spec) else { continue };
            let (from, ratio) = match (written, self.of_inherited) {
                (Some(_), Some(of_inherited)) => (*value, of_inherited),
                _ => (*paper, self.of_paper),
            };
            let scaled = if ratio == 1.0 { from } else { rounded(from * ratio) };
            if written.is_some() && scaled != *value {
                inherited.push(format!("{key} {scaled}"));
            }
            *value = scaled;
        }
        inherited
    }
}

/// The size of the robot that the sources weaker than `rank` choose.
fn size_below(document: &Document, rank: usize) -> Option<RobotSize> {
    let model = document.below(rank, &KeyPath::default().key("model"))?;
    deserialize::<PlantSpec>(&model, &[]).ok()?.size()
}

/// A simulated robot of large levers moves as far as its travel asks for.
fn make_room(spec: &mut Experiment, document: &Document, travel_m: f64) {
    for (key, plant) in [("model", &mut spec.model), ("plant", &mut spec.plant)] {
        let written = document.has(&key_path(&format!("{key}.simulated.travel_m")));
        if let (PlantSpec::Simulated(robot), false) = (plant, written) {
            robot.travel_m = robot.travel_m.max(2.0 * travel_m);
        }
    }
}

/// The note on commands that bend a segment of the robot far, where there are any.
pub(crate) fn far_bends(spec: &Experiment) -> Option<String> {
    let size = spec.model.size()?;
    let points_m = match spec.gp_points.layout {
        PointLayout::Grid(grid) => grid.max_pull_m,
        PointLayout::Walk { max_pull_m, .. } => max_pull_m,
    };
    let commands = [
        ("explore.max_pull_m", spec.explore.max_pull_m),
        ("gp_points.layout", points_m),
        ("targets.sweep.max_pull_m", spec.targets.sweep.max_pull_m),
        ("path.radius_m", spec.path.radius_m * (1.0 + spec.path.petal_share)),
        ("policies.limits.travel_m", spec.policies.limits.travel_m),
    ];
    let bends = commands.map(|(key, pull_m)| (key, pull_m / size.lever_m));
    let far: Vec<&str> = bends
        .iter()
        .filter(|(_, bend_rad)| *bend_rad > MAX_BEND_RAD)
        .map(|(key, _)| *key)
        .collect();
    let farthest_rad = bends.iter().fold(0.0_f64, |most, (_, bend_rad)| most.max(*bend_rad));
    (!far.is_empty()).then(|| {
        format!(
            "{}: {} bend a segment by up to {farthest_rad:.1} rad over a lever of {} m, expected \
             at most {MAX_BEND_RAD} rad; `travel_m: {}` bends by {TRAVEL_RAD}",
            spec.name,
            far.join(", "),
            rounded(size.lever_m),
            suited_travel_m(Some(size))
        )
    })
}

fn key_path(keys: &str) -> KeyPath {
    KeyPath::parse(keys).unwrap_or_default()
}

/// A number with so many digits as a person would write.
fn rounded(value: f64) -> f64 {
    let shift = 10_f64.powi(DIGITS - 1 - value.abs().log10().floor() as i32);
    if value > 0.0 && shift.is_finite() { (value * shift).round() / shift } else { value }
}
