//! Derivatives of tracked points along whole recordings, to numbers of the model and of the points themselves.

use super::support::{RELATIVE, shipped};
use spinebench::base::Point3;
use spinebench::data::{Actuation, Recording};
use spinebench::effects::{BodyPoint, Model, ModelParameter, Variable};
use spinebench::tasks::{SimulationOptions, simulate_recording, simulate_with_rates};

fn model() -> Model {
    let mut model = shipped("nominal");
    let mut put =
        |name: &str, s_m: f64, offset_m| model.tracking.points.insert(name.to_owned(), BodyPoint { s_m, offset_m });
    put("disk", 0.0823, [0.0, 0.0, 0.003]);
    put("marker", 0.151, [0.02, -0.01, 0.0]);
    put("tip", 0.22, [0.0; 3]);
    model
}

fn commands() -> Recording {
    let mut commands = Recording::new(Actuation::Lengths, 4);
    for row in 0..10 {
        let (x, y) = (0.0121 * (0.6 * f64::from(row) + 0.3).sin(), 0.009 * (0.45 * f64::from(row)).cos());
        commands.trial.push(u64::from(row >= 6));
        commands.time_s.push(0.2 * f64::from(row % 6));
        commands.commands.push(&[x, y, -x, -y]);
    }
    commands
}

/// All positions of the points, row by row.
fn points_m(recording: &Recording) -> Vec<Point3> {
    (0..recording.len()).flat_map(|row| recording.points.iter().map(move |point| point.position_m[row])).collect()
}

#[test]
fn points_in_rest_and_motion() {
    let (model, commands) = (model(), commands());
    let paths = [
        "robot.backbone.youngs_modulus_pa",
        "robot.tendons.angles_deg[1]",
        "robot.base_rotation_rad[0]",
        "robot.gravity_m_s2[0]",
        "tracking.points.disk.s_m",
        "tracking.points.marker.offset_m[0]",
        "tracking.points.tip.s_m",
    ];
    let parameters = paths.map(|path| ModelParameter::named(&model, path).unwrap());
    let variables: Vec<Variable> = parameters.iter().cloned().map(Variable::Parameter).collect();
    for at_rest in [true, false] {
        let options = SimulationOptions { at_rest, ..SimulationOptions::default() };
        let found = simulate_with_rates(&model, &commands, &options, &variables).unwrap();
        assert!(found.left_out.is_empty());
        assert_eq!(
            found.recording,
            simulate_recording(&model, &commands, &options),
            "those who follow disturb nothing"
        );
        let tip = found.recording.point("tip").unwrap();
        assert_eq!(Some(&tip.position_m), found.recording.tip_m.as_ref());
        for (index, parameter) in parameters.iter().enumerate() {
            let rates: Vec<Point3> =
                found.rates.iter().flat_map(|row| &row[index].points).map(|rate| rate.position_m.into()).collect();
            let simulated = |model: &Model| -> Result<Vec<Point3>, spinebench::effects::VariationError> {
                Ok(points_m(&simulate_recording(model, &commands, &options)))
            };
            let scale = parameter.scale(&model).unwrap();
            let size = |all: &[Point3]| all.iter().flatten().map(|x| x * x).sum::<f64>().sqrt() * scale;
            let off = [1e-2, 1e-3, 1e-4, 1e-5].map(|step| {
                let differences = parameter.differences(&model, step, &simulated).unwrap();
                (size(&super::support::minus(&rates, &differences)), size(&differences))
            });
            let (least, whole) = off.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
            println!("{parameter} at rest {at_rest}: {whole:.2e} m, off by {least:.1e} m");
            assert!(least < RELATIVE * whole + 5e-8, "{parameter}, at rest {at_rest}: {off:?}");
        }
    }
}
