//! Derivatives of tracked points along whole recordings, to numbers of the model and of the points
//! themselves.

use super::support::{RELATIVE, shipped};
use spinebench::base::Point3;
use spinebench::data::recording::{DriveTrack, DriveUnit};
use spinebench::data::{Actuation, Recording};
use spinebench::effects::{
    BodyPoint, Model, ModelParameter, PerTendon, Starts, TendonDrive, Tracking, Variable,
};
use spinebench::tasks::{SimulationOptions, simulate_recording, simulate_with_rates};

fn model() -> Model {
    let mut model = shipped("nominal");
    let mut put = |name: &str, s_m: f64, offset_m| {
        model.tracking.points.insert(name.to_owned(), BodyPoint { s_m, offset_m })
    };
    put("disk", 0.0823, [0.0, 0.0, 0.003]);
    put("marker", 0.151, [0.02, -0.01, 0.0]);
    put("tip", 0.22, [0.0; 3]);
    model
}

fn commands() -> Recording {
    let mut commands = Recording::new(Actuation::Lengths, 4);
    for row in 0..10 {
        let (x, y) =
            (0.0121 * (0.6 * f64::from(row) + 0.3).sin(), 0.009 * (0.45 * f64::from(row)).cos());
        commands.trial.push(u64::from(row >= 6));
        commands.time_s.push(0.2 * f64::from(row % 6));
        commands.commands.push(&[x, y, -x, -y]);
    }
    commands
}

/// The same commands through two drives, each of which moves two tendons.
fn driven(model: &mut Model) -> Recording {
    let drive =
        |tendons: [usize; 2]| TendonDrive { tendons: tendons.to_vec(), gains: vec![0.02, -0.02] };
    model.drives.insert("across".to_owned(), drive([2, 4]));
    model.drives.insert("up".to_owned(), drive([1, 3]));
    let mut commands = commands();
    let track = |name: &str, tendon: usize| DriveTrack {
        name: name.to_owned(),
        unit: DriveUnit::Radians,
        displacement: commands.commands.iter().map(|row| row[tendon] / 0.02).collect(),
    };
    commands.drives = vec![track("across", 1), track("up", 0)];
    commands
}

/// All positions of the points, row by row.
fn points_m(recording: &Recording) -> Vec<Point3> {
    (0..recording.len())
        .flat_map(|row| recording.points.iter().map(move |point| point.position_m[row]))
        .collect()
}

/// Compares the derivatives of all points with differences of whole recordings.
fn compare(model: &Model, commands: &Recording, paths: &[&str]) {
    let parameters: Vec<ModelParameter> =
        paths.iter().map(|path| ModelParameter::named(model, path).unwrap()).collect();
    let variables: Vec<Variable> = parameters.iter().cloned().map(Variable::Parameter).collect();
    for at_rest in [true, false] {
        let options = SimulationOptions { at_rest, ..SimulationOptions::default() };
        let found = simulate_with_rates(model, commands, &options, &variables).unwrap();
        assert!(found.left_out.is_empty());
        assert_eq!(
            found.recording,
            simulate_recording(model, commands, &options),
            "those who follow disturb nothing"
        );
        let tip = found.recording.point("tip").unwrap();
        assert_eq!(Some(&tip.position_m), found.recording.tip_m.as_ref());
        for (index, parameter) in parameters.iter().enumerate() {
            let rates = found.rates.iter().flat_map(|row| &row[index].points);
            let rates: Vec<Point3> = rates.map(|rate| rate.position_m.into()).collect();
            let simulated =
                |model: &Model| -> Result<Vec<Point3>, spinebench::effects::VariationError> {
                    Ok(points_m(&simulate_recording(model, commands, &options)))
                };
            let scale = parameter.scale(model).unwrap();
            let size =
                |all: &[Point3]| all.iter().flatten().map(|x| x * x).sum::<f64>().sqrt() * scale;
            let off = [1e-2, 1e-3, 1e-4, 1e-5].map(|step| {
                let differences = parameter.differences(model, step, &simulated).unwrap();
                (size(&super::support::minus(&rates, &differences)), size(&differences))
            });
            let (least, whole) = off.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
            println!("{parameter} at rest {at_rest}: {whole:.2e} m, off by {least:.1e} m");
            assert!(least < RELATIVE * whole + 5e-8, "{parameter}, at rest {at_rest}: {off:?}");
        }
    }
}

/// A marker beyond the end of the backbone that recordings call the tip.
#[test]
fn a_tip_away_from_the_end_of_the_backbone() {
    let (mut model, commands) = (model(), commands());
    let tip = BodyPoint { s_m: 0.2145, offset_m: [0.002, -0.004, 0.0105] };
    model.tracking.tip = Some(tip);
    model.tracking.points.insert("tip".to_owned(), tip);
    let options = SimulationOptions { at_rest: true, ..SimulationOptions::default() };
    let end = simulate_recording(
        &Model { tracking: Tracking::default(), ..model.clone() },
        &commands,
        &options,
    );
    let beyond = simulate_recording(&model, &commands, &options);
    let apart = |row: usize| {
        spinebench::base::distance_m(
            &end.tip_m.as_ref().unwrap()[row],
            &beyond.tip_m.as_ref().unwrap()[row],
        )
    };
    assert!(
        (0..10).all(|row| (apart(row) - 0.0067).abs() < 5e-4),
        "{:?}",
        (0..10).map(apart).collect::<Vec<_>>()
    );
    let paths =
        ["tracking.tip.offset_m[2]", "tracking.tip.s_m", "robot.backbone.youngs_modulus_pa"];
    let variables: Vec<Variable> = paths
        .iter()
        .map(|path| Variable::Parameter(ModelParameter::named(&model, path).unwrap()))
        .collect();
    let found = simulate_with_rates(&model, &commands, &options, &variables).unwrap();
    for row in &found.rates {
        // The point that stands where the tip does moves with it, but for what moves the tip's
        // place alone.
        assert_eq!(row[2].tip, *row[2].points.last().unwrap());
        assert!(
            row[0].points.iter().all(|rate| rate.position_m.norm() == 0.0)
                && (row[0].tip.position_m.norm() - 1.0).abs() < 1e-6
        );
        assert!((row[1].tip.position_m.norm() - 1.0).abs() < 0.2, "{}", row[1].tip.position_m);
    }
}

#[test]
fn points_in_rest_and_motion() {
    let paths = [
        "robot.backbone.youngs_modulus_pa",
        "robot.tendons.angles_deg[1]",
        "robot.base_rotation_rad[0]",
        "robot.gravity_m_s2[0]",
        "tracking.points.disk.s_m",
        "tracking.points.marker.offset_m[0]",
        "tracking.points.tip.s_m",
    ];
    compare(&model(), &commands(), &paths);
}

/// Gains of drives, and numbers of single tendons, also where trials start under their first
/// command or go on.
#[test]
fn gains_of_drives_from_any_start() {
    let mut model = model();
    let commands = driven(&mut model);
    let tendons = &mut model.robot.tendons;
    tendons.pretension_m = PerTendon::Each(vec![5e-4, 4e-4, 5e-4, 6e-4]);
    tendons.compliance_m_per_n = PerTendon::Each(vec![1e-4, 2e-4, 1e-4, 2e-4]);
    let paths = [
        "drives.across.gains[0]",
        "drives.up.gains[1]",
        "robot.tendons.pretension_m[1]",
        "robot.tendons.compliance_m_per_n[3]",
    ];
    for starts in [Starts::Home, Starts::Anywhere, Starts::Continue] {
        model.tracking.starts = starts;
        compare(&model, &commands, &paths);
    }
}
