//! Models, commands and what derivatives may be off by.

use spinebench::base::{Point3, Rows};
use spinebench::effects::{Model, ReplayError, Starts, Trial, replay};

/// Size of the loops on the nominal robot: one at which no Gauss point of the friction tests comes
/// to rest on the edge between stick and slip, where the derivatives to both sides differ
/// (docs/method/sensitivities.md).
pub(crate) const SIZE_M: f64 = 0.0121;

/// What derivatives may be off by: this share of themselves, …
pub(crate) const RELATIVE: f64 = 1e-4;
/// … this where whole runs are no smoother (dry friction, a long whip), …
pub(crate) const ROUGH: f64 = 5e-4;
/// … and this much for a change of the number by its scale, in lengths of
/// the robot.
pub(crate) const ABSOLUTE: f64 = 2.5e-8;
/// The same for robots whose tendons alone say where they are: a stiffness changes all forces and
/// hardly the shape.
pub(crate) const ABSOLUTE_FIXED: f64 = 5e-7;

pub(crate) fn yaml<T: serde::de::DeserializeOwned>(text: &str) -> T {
    serde_yaml::with::singleton_map_recursive::deserialize(serde_yaml::Deserializer::from_str(text))
        .unwrap_or_else(|error| panic!("{error} in\n{text}"))
}

/// A shipped model with steps of one length: where they follow from an error estimate, whole runs
/// jump when it changes its mind, and their differences with them.
pub(crate) fn shipped(name: &str) -> Model {
    let mut model = adaptive(name);
    model.robot.resolution.motion_tolerance_m = f64::INFINITY;
    // One and two steps for the way and the wait of the drives: their number stays when the time of
    // the way changes.
    model.robot.resolution.time_step_s = 0.1;
    model
}

/// A shipped model as it is.
pub(crate) fn adaptive(name: &str) -> Model {
    let path = format!("{}/models/{name}.yaml", env!("CARGO_MANIFEST_DIR"));
    yaml(&std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}")))
}

/// Commands of one trial.
pub(crate) struct Commands {
    pub(crate) rows: Rows,
    pub(crate) durations_s: Vec<f64>,
    pub(crate) tensions: bool,
    pub(crate) at_rest: bool,
}

impl Commands {
    /// Loops with reversals: opposite tendons pull and give way, so that tendons go slack and taut.
    pub(crate) fn loops(model: &Model, size_m: f64, at_rest: bool) -> Commands {
        let tendons = model.robot.tendons.angles_deg.len();
        let mut rows = Rows::new(tendons);
        for k in 0..12 {
            let (x, y) = (
                size_m * (0.6 * f64::from(k) + 0.3).sin(),
                0.75 * size_m * (0.45 * f64::from(k)).cos(),
            );
            let angle = |degrees: &f64| degrees.to_radians();
            let pull = |degrees: &f64| x * angle(degrees).cos() + y * angle(degrees).sin();
            rows.push(&model.robot.tendons.angles_deg.iter().map(pull).collect::<Vec<f64>>());
        }
        Commands { durations_s: vec![0.2; rows.len()], rows, tensions: false, at_rest }
    }

    pub(crate) fn trial(&self) -> Trial<'_> {
        let Commands { rows, durations_s, tensions, at_rest } = self;
        Trial {
            commands: rows,
            durations_s,
            tensions: *tensions,
            at_rest: *at_rest,
            starts: Starts::Home,
            tip_loads: None,
        }
    }

    pub(crate) fn tips(&self, model: &Model) -> Result<Vec<Point3>, ReplayError> {
        replay(model, &[], &self.trial(), &[]).map(|replayed| replayed.tips_m)
    }
}

pub(crate) fn rows<const N: usize>(commands: &[[f64; N]]) -> Rows {
    let mut rows = Rows::new(N);
    commands.iter().for_each(|command| rows.push(command));
    rows
}

pub(crate) fn rms(points: &[Point3]) -> f64 {
    (points.iter().flatten().map(|x| x * x).sum::<f64>() / points.len() as f64).sqrt()
}

pub(crate) fn minus(a: &[Point3], b: &[Point3]) -> Vec<Point3> {
    a.iter().zip(b).map(|(p, q)| std::array::from_fn(|axis| p[axis] - q[axis])).collect()
}
