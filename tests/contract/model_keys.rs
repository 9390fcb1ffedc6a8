//! The keys of a model file: what they mean, and what is refused.

use nalgebra::Vector3;
use spinebench::effects::Model;
use spinebench::rod::{Drive, Rod, RodParams, SolveStatus};
use spinebench::specs::{model_text, read_model};

/// A model without tendons' and backbone's details: `{backbone}`, `{tendons}` and `{more}` are
/// filled in.
const FRAME: &str = "robot:\n  backbone: {backbone}\n  tendons: {tendons}\n{more}";
const BACKBONE: &str = "{length_m: 0.2, radius_m: 0.003, youngs_modulus_pa: 2e9, poisson_ratio: \
                        0.3, density_kg_m3: 1200}";
const TENDONS: &str = "{radius_m: 0.01, angles_deg: [0, 120, 240]}";

fn read(backbone: &str, tendons: &str, more: &str) -> Result<Model, String> {
    let text =
        FRAME.replace("{backbone}", backbone).replace("{tendons}", tendons).replace("{more}", more);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("m.yaml");
    std::fs::write(&file, text).unwrap();
    read_model(&file)
        .map_err(|error| error.to_string().replace(&format!("{}/", folder.path().display()), ""))
}

fn model(backbone: &str, tendons: &str, more: &str) -> Model {
    read(backbone, tendons, more).unwrap_or_else(|error| panic!("{error}"))
}

fn tip(params: RodParams) -> Vector3<f64> {
    let mut rod = Rod::new(params);
    assert_eq!(
        rod.settle(&[Drive::Tension(3.0), Drive::Pull(0.002), Drive::Tension(0.5)]),
        SolveStatus::Converged
    );
    rod.tip_m()
}

fn with(text: &str, key: &str) -> String {
    text.replace('}', &format!(", {key}}}"))
}

#[test]
fn longer_ways_to_say_the_same_change_nothing() {
    let plain = model(BACKBONE, TENDONS, "");
    let home = tip(plain.rod(&[]));
    let short = "{length_m: 0.2, radius_m: 0.003, youngs_modulus_pa: 1e9, poisson_ratio: 0.3, \
                 density_kg_m3: 1200, pieces: [{end_m: 0.2, youngs_modulus_pa: 2e9}]}";
    let same = [
        (with(BACKBONE, "pieces: [{end_m: 0.2}]"), TENDONS.to_owned(), ""),
        (with(BACKBONE, "inner_radius_m: 0"), TENDONS.to_owned(), ""),
        (short.to_owned(), TENDONS.to_owned(), ""),
        (BACKBONE.to_owned(), with(TENDONS, "radii_m: [0.01, 0.01, 0.01]"), ""),
        (BACKBONE.to_owned(), with(TENDONS, "pretension_m: 0, compliance_m_per_n: [0, 0, 0]"), ""),
        (
            BACKBONE.to_owned(),
            with(TENDONS, "profile: [], twists_rad_m: [0, 0, 0], starts_m: [0, 0, 0]"),
            "",
        ),
        (BACKBONE.to_owned(), with(TENDONS, "paths: [[{s_m: 0, x_m: 0.01, y_m: 0}], [], []]"), ""),
        (BACKBONE.to_owned(), TENDONS.to_owned(), "  loads: []\n"),
    ];
    for (backbone, tendons, more) in &same {
        assert_eq!(
            tip(model(backbone, tendons, more).rod(&[])),
            home,
            "{backbone} {tendons} {more}"
        );
    }
    // Cut differently: the same rod, computed on another grid.
    let nearly = [
        (
            with(BACKBONE, "pieces: [{end_m: 0.07}, {end_m: 0.2, radius_m: 0.003}]"),
            TENDONS.to_owned(),
            "",
        ),
        (BACKBONE.to_owned(), with(TENDONS, "profile: [{s_m: 0.1, radius_m: 0.01}]"), ""),
        (
            BACKBONE.to_owned(),
            TENDONS.to_owned(),
            "  loads: [{point: {position_m: 0.1}}, {line: {force_n_m: [0, 0, 0]}}]\n",
        ),
    ];
    for (backbone, tendons, more) in &nearly {
        let off = (tip(model(backbone, tendons, more).rod(&[])) - home).norm();
        assert!(off < 1e-6, "{off:e}: {backbone} {tendons} {more}");
    }
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of cases")]
fn every_key_does_something() {
    let home = tip(model(BACKBONE, TENDONS, "").rod(&[]));
    let cases = [
        (with(BACKBONE, "inner_radius_m: 0.002"), TENDONS.to_owned(), ""),
        (with(BACKBONE, "pieces: [{end_m: 0.2, end_radius_m: 0.002}]"), TENDONS.to_owned(), ""),
        (
            with(
                BACKBONE,
                "pieces: [{end_m: 0.2, inner_radius_m: 0.001, end_inner_radius_m: 0.002}]",
            ),
            TENDONS.to_owned(),
            "",
        ),
        (with(BACKBONE, "pieces: [{end_m: 0.2, poisson_ratio: 0.1}]"), TENDONS.to_owned(), ""),
        (
            with(BACKBONE, "pieces: [{end_m: 0.1}, {end_m: 0.2, density_kg_m3: 9000}]"),
            TENDONS.to_owned(),
            "",
        ),
        (
            with(BACKBONE, "pieces: [{end_m: 0.1}, {end_m: 0.2, axial_stiffness_n: 9000}]"),
            TENDONS.to_owned(),
            "",
        ),
        (
            with(BACKBONE, "pieces: [{end_m: 0.1}, {end_m: 0.2, shear_stiffness_n: 900}]"),
            TENDONS.to_owned(),
            "",
        ),
        (
            with(BACKBONE, "pieces: [{end_m: 0.2, bending_stiffness_n_m2: 0.2}]"),
            TENDONS.to_owned(),
            "",
        ),
        (
            with(BACKBONE, "pieces: [{end_m: 0.2, torsion_stiffness_n_m2: 0.01}]"),
            TENDONS.to_owned(),
            "",
        ),
        (with(BACKBONE, "pieces: [{end_m: 0.2, anisotropy: 0.3}]"), TENDONS.to_owned(), ""),
        (
            with(BACKBONE, "pieces: [{end_m: 0.2, anisotropy: 0.3, principal_angle_deg: 40}]"),
            TENDONS.to_owned(),
            "",
        ),
        (
            with(BACKBONE, "pieces: [{end_m: 0.2, rest_curvature_rad_m: [1, 2, 3]}]"),
            TENDONS.to_owned(),
            "",
        ),
        (BACKBONE.to_owned(), with(TENDONS, "radii_m: [0.01, 0.012, 0.01]"), ""),
        (BACKBONE.to_owned(), with(TENDONS, "pretension_m: 0.001"), ""),
        (BACKBONE.to_owned(), with(TENDONS, "pretension_m: [0, 0.002, 0]"), ""),
        (BACKBONE.to_owned(), with(TENDONS, "compliance_m_per_n: 0.001"), ""),
        (BACKBONE.to_owned(), with(TENDONS, "compliance_m_per_n: [0, 0.002, 0]"), ""),
        (BACKBONE.to_owned(), with(TENDONS, "profile: [{s_m: 0.2, radius_m: 0.005}]"), ""),
        (BACKBONE.to_owned(), with(TENDONS, "twists_rad_m: [0, 5, 0]"), ""),
        (
            BACKBONE.to_owned(),
            with(TENDONS, "paths: [[{s_m: 0, x_m: 0.01, y_m: 0.001}], [], []]"),
            "",
        ),
        (BACKBONE.to_owned(), with(TENDONS, "starts_m: [0.05, 0, 0]"), ""),
        (
            BACKBONE.to_owned(),
            TENDONS.to_owned(),
            "  loads: [{point: {position_m: 0.1, force_n: [0.3, 0, 0]}}]\n",
        ),
        (
            BACKBONE.to_owned(),
            TENDONS.to_owned(),
            "  loads: [{point: {position_m: 0.2, moment_nm: [0.01, 0, 0]}}]\n",
        ),
        (
            BACKBONE.to_owned(),
            TENDONS.to_owned(),
            "  loads: [{point: {position_m: 0.1, force_n: [0.3, 0, 0], frame: body}}]\n",
        ),
        (
            BACKBONE.to_owned(),
            TENDONS.to_owned(),
            "  loads: [{line: {start_m: 0.1, force_n_m: [0, 1, 0]}}]\n",
        ),
        (
            BACKBONE.to_owned(),
            TENDONS.to_owned(),
            "  loads: [{line: {end_m: 0.15, force_n_m: [0, 1, 0]}}]\n",
        ),
        (
            BACKBONE.to_owned(),
            TENDONS.to_owned(),
            "  disks: {count: 1, mass_kg: 0.02, positions_m: [0.1]}\n",
        ),
        (
            BACKBONE.to_owned(),
            TENDONS.to_owned(),
            "  disks: {count: 1, mass_kg: 0.02, positions_m: [0.1], masses_kg: [0.05]}\n",
        ),
    ];
    let mut seen: Vec<Vector3<f64>> = vec![home];
    let folder = tempfile::tempdir().unwrap();
    for (backbone, tendons, more) in &cases {
        let read = model(backbone, tendons, more);
        let there = tip(read.rod(&[]));
        let nearest = seen.iter().map(|other| (other - there).norm()).fold(f64::INFINITY, f64::min);
        assert!(nearest > 1e-9, "{nearest:e}: {backbone} {tendons} {more}");
        seen.push(there);
        // What is written reads back as the same robot.
        let file = folder.path().join("again.yaml");
        std::fs::write(&file, model_text(&read).unwrap()).unwrap();
        assert_eq!(read_model(&file).unwrap(), read, "{backbone} {tendons} {more}");
    }
}

/// A robot that is curved at rest has its tendons fitted to that shape; a precurvature that was not
/// meant pulls at them.
#[test]
fn tendons_are_fitted_to_the_curved_backbone_but_not_to_an_unwanted_precurvature() {
    let curved = "{length_m: 0.2, radius_m: 0.003, youngs_modulus_pa: 2e9, poisson_ratio: 0.3, \
                  pieces: [{end_m: 0.2, rest_curvature_rad_m: [0, 4, 0]}]}";
    let rest = |model: Model| {
        let mut rod = Rod::new(model.rod(&[]));
        assert_eq!(rod.settle(&[Drive::Pull(0.0); 3]), SolveStatus::Converged);
        (rod.tip_m(), rod.tensions_n().iter().sum::<f64>())
    };
    let (tip_m, tension_n) = rest(model(curved, TENDONS, "  gravity_m_s2: [0, 0, 0]\n"));
    let arc = Vector3::new((1.0 - 0.8_f64.cos()) / 4.0, 0.0, 0.8_f64.sin() / 4.0);
    assert!((tip_m - arc).norm() < 1e-8 && tension_n < 1e-6, "{tip_m} {tension_n}");
    let effect = "  gravity_m_s2: [0, 0, 0]\neffects: [{precurvature: {kappa_x_rad_m: 0, \
                  kappa_y_rad_m: 4}}]\n";
    let (tip_m, tension_n) = rest(model(BACKBONE, TENDONS, effect));
    assert!((tip_m - arc).norm() > 0.02 && tension_n > 1.0, "{tip_m} {tension_n}");
}

/// What is added to the backbone, the tendons or the robot; the line of the error; what it says.
const BAD: &[(Place, &str, usize, &str)] = &[
    (
        Place::Backbone,
        "inner_radius_m: 0.003",
        2,
        "robot.backbone.inner_radius_m: found 0.003, expected",
    ),
    (
        Place::Backbone,
        "pieces: [{end_m: 0.1}]",
        2,
        "robot.backbone.pieces[0].end_m: found 0.1, expected the last piece",
    ),
    (
        Place::Backbone,
        "pieces: [{end_m: 0.1}, {end_m: 0.1}]",
        2,
        "robot.backbone.pieces[1].end_m: found 0.1, expected a place beyond",
    ),
    (
        Place::Backbone,
        "pieces: [{end_m: 0.2, end_radius_m: 0}]",
        2,
        "robot.backbone.pieces[0].end_radius_m: found 0, expected",
    ),
    (
        Place::Backbone,
        "pieces: [{end_m: 0.2, end_inner_radius_m: 0.004}]",
        2,
        "robot.backbone.pieces[0].end_inner_radius_m: found 0.004",
    ),
    (
        Place::Backbone,
        "pieces: [{end_m: 0.2, anisotropy: 1}]",
        2,
        "robot.backbone.pieces[0].anisotropy: found 1.0, expected a number between",
    ),
    (
        Place::Backbone,
        "pieces: [{end_m: 0.2, youngs_modulus_pa: -1}]",
        2,
        "robot.backbone.pieces[0].youngs_modulus_pa: found -1",
    ),
    (Place::Backbone, "pieces: [{length_m: 0.2}]", 2, "found the unknown key `length_m`"),
    (
        Place::Backbone,
        "pieces: [{radius_m: 0.2}]",
        2,
        "robot.backbone.pieces[0].end_m: found no such key",
    ),
    (
        Place::Tendons,
        "radii_m: [0.01, 0.01]",
        3,
        "robot.tendons.radii_m: found [0.01, 0.01], expected one number above 0 per tendon",
    ),
    (
        Place::Tendons,
        "pretension_m: [0.001, 0.001]",
        3,
        "robot.tendons.pretension_m: found [0.001, 0.001], expected a number, or a list of one \
         number per tendon",
    ),
    (
        Place::Tendons,
        "compliance_m_per_n: [0, -1, 0]",
        3,
        "robot.tendons.compliance_m_per_n: found -1, expected a finite number of at least 0",
    ),
    (
        Place::Tendons,
        "pretension_m: tight",
        3,
        "expected a number, or a list of one number per tendon",
    ),
    (
        Place::Tendons,
        "twists_rad_m: [1]",
        3,
        "robot.tendons.twists_rad_m: found [1.0], expected one number per tendon",
    ),
    (
        Place::Tendons,
        "starts_m: [0, 0.15, 0], ends_m: [0.2, 0.1, 0.2]",
        3,
        "robot.tendons.starts_m: found",
    ),
    (
        Place::Tendons,
        "profile: [{s_m: 0, radius_m: 0.01}]",
        3,
        "robot.tendons.profile[0].s_m: found 0.0, expected a place further",
    ),
    (
        Place::Tendons,
        "profile: [{s_m: 0.1, radius_m: .nan}]",
        3,
        "robot.tendons.profile[0].radius_m: found",
    ),
    (
        Place::Tendons,
        "paths: [[], [{s_m: 0.1, x_m: 0, y_m: 0}, {s_m: 0.1, x_m: 0, y_m: 0}], []]",
        3,
        "robot.tendons.paths[1][1].s_m: found 0.1",
    ),
    (Place::Tendons, "paths: [[], [{s_m: 0.1, x: 0, y_m: 0}], []]", 3, "found the unknown key `x`"),
    (
        Place::Tendons,
        "paths: [[]]",
        3,
        "robot.tendons.paths: found 1, expected one path per tendon",
    ),
    (
        Place::Robot,
        "  loads: [{point: {position_m: 0.3}}]\n",
        4,
        "robot.loads[0].point.position_m: found 0.3, expected a place on the backbone",
    ),
    (
        Place::Robot,
        "  loads: [{point: {position_m: 0.1, frame: tip}}]\n",
        4,
        "found the unknown name `tip`, expected one of `world`, `body`",
    ),
    (
        Place::Robot,
        "  loads:\n  - point: {position_m: 0.1}\n  - line: {start_m: 0.1, end_m: 0.05, force_n_m: \
         [0, 0, 1]}\n",
        6,
        "robot.loads[1].line.end_m: found 0.05",
    ),
    (
        Place::Robot,
        "  loads: [{line: {force_n: [0, 0, 1]}}]\n",
        4,
        "found the unknown key `force_n`",
    ),
    (
        Place::Robot,
        "  disks: {count: 1, mass_kg: 0.1, masses_kg: [0.1]}\n",
        4,
        "robot.disks.masses_kg: found [0.1], expected `positions_m` in addition",
    ),
    (
        Place::Robot,
        "  disks: {count: 1, mass_kg: 0.1, positions_m: [0.1], masses_kg: [-1]}\n",
        4,
        "robot.disks.masses_kg: found -1",
    ),
    (
        Place::Robot,
        "obstacles: [{plane: {normal: [0, 0, 0], distance_m: -0.1}}]\n",
        4,
        "obstacles[0].plane.normal: found [0.0, 0.0, 0.0], expected a vector that is not zero",
    ),
    (
        Place::Robot,
        "obstacles:\n- plane: {normal: [1, 0, 0], distance_m: -0.1}\n- sphere: {center_m: [0.1, 0, \
         0.1], radius_m: -0.01}\n",
        6,
        "obstacles[1].sphere.radius_m: found -0.01, expected a finite number above 0",
    ),
    (
        Place::Robot,
        "obstacles: [{sphere: {center_m: [0.021, 0, 0.1], radius_m: 0.02}}]\n",
        4,
        "obstacles[0].sphere: found 2.000 mm of it in the straight robot, 0.1000 m from its base, \
         expected",
    ),
    (
        Place::Robot,
        "obstacles: [{friction_coefficient: 0.1}]\n",
        4,
        "found 0 shapes in one obstacle, expected one of",
    ),
    (
        Place::Robot,
        "obstacles: [{plane: {normal: [1, 0, 0], distance_m: -0.1}, friction_coefficient: -0.1}]\n",
        4,
        "obstacles[0].friction_coefficient: found -0.1",
    ),
    (
        Place::Robot,
        "obstacles: [{plane: {normal: [1, 0, 0]}}]\n",
        4,
        "obstacles[0].plane.distance_m: found no such key",
    ),
    (Place::Robot, "  contact_radius_m: -0.001\n", 4, "robot.contact_radius_m: found -0.001"),
    (
        Place::Robot,
        "tracking: {rested_s: -2}\n",
        4,
        "tracking.rested_s: found -2, expected 0 or more",
    ),
    (
        Place::Robot,
        "tracking: {starts: anywhere, rested_s: 2}\n",
        4,
        "tracking.rested_s: found 2, expected no such key unless trials start at home",
    ),
];

enum Place {
    Backbone,
    Tendons,
    Robot,
}

#[test]
fn bad_keys_are_refused_by_file_line_and_key() {
    for (place, key, line, said) in BAD {
        let error = match place {
            Place::Backbone => read(&with(BACKBONE, key), TENDONS, ""),
            Place::Tendons => read(BACKBONE, &with(TENDONS, key), ""),
            Place::Robot => read(BACKBONE, TENDONS, key),
        };
        let error = error.expect_err(said);
        let place = format!("m.yaml:{line}:");
        assert!(
            error.starts_with(&place) && error.contains(said),
            "wanted {place} … {said}\n   got {error}"
        );
    }
}

#[test]
fn every_shipped_model_reads_settles_and_survives_a_round_trip() {
    let folder = tempfile::tempdir().unwrap();
    let models = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
    let mut count = 0;
    let folders = [models.clone(), models.join("real")];
    let paths = folders
        .iter()
        .flat_map(|folder| std::fs::read_dir(folder).unwrap().flatten().map(|entry| entry.path()));
    for file in paths.filter(|path| path.is_file()) {
        let model = read_model(&file).unwrap_or_else(|error| panic!("{error}"));
        let again = folder.path().join("again.yaml");
        std::fs::write(&again, model_text(&model).unwrap()).unwrap();
        assert_eq!(read_model(&again).unwrap(), model, "{}", file.display());
        let mut rod = Rod::new(model.rod(&[]));
        let drives = vec![Drive::Pull(0.0); model.robot.tendons.angles_deg.len()];
        assert_eq!(rod.settle(&drives), SolveStatus::Converged, "{}", file.display());
        count += 1;
    }
    assert!(count >= 11, "{count}");
}
