//! The robot's frame in the tracker's, found through the drivers.

use super::bench::{Bench, ROOT};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use spinebench::hardware::tracking::RigidPose;
use spinebench::specs::{PlantSpec, read_plant};
use std::path::Path;

/// Where the base frame of the imitated robot is in the base body's.
fn hidden() -> RigidPose {
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.2, -0.1, 1.2));
    RigidPose::of(&Isometry3::from_parts(Translation3::new(0.03, -0.015, 0.02), turn))
}

fn put_plant(bench: &Bench, model: &str) {
    let RigidPose { position_m, quaternion } = hidden();
    let alignment = format!("{{position_m: {position_m:?}, quaternion: {quaternion:?}}}");
    bench.put(
        "plant.yaml",
        &format!(
            "hardware: {{name: robot, model: {ROOT}/models/nominal.yaml, rehearsal: {{model: \
             {model}, noise_m: 0.0001, alignment: {alignment}}}}}\n"
        ),
    );
}

fn alignment(file: &Path) -> RigidPose {
    let PlantSpec::Hardware(options) = read_plant(file).unwrap() else { panic!("no robot") };
    options.tracking.alignment
}

fn is_found(found: &RigidPose) {
    let apart = hidden().motion().inv_mul(&found.motion());
    let (m, rad) = (apart.translation.vector.norm(), apart.rotation.angle());
    assert!(m < 0.001 && rad < 0.005, "{m} m, {rad} rad");
}

#[test]
fn a_turned_and_shifted_tracker_is_found() {
    let bench = Bench::new();
    put_plant(&bench, &format!("{ROOT}/models/nominal.yaml"));
    // What is wrong shows before, and is gone after.
    bench.run("doctor --plant plant.yaml --move").is(1, &["robot stopped: the measured tip is"]);
    let ended = bench.run("align --plant plant.yaml --move --out aligned.yaml");
    ended.is(0, &["tracking:\n  alignment:\n    position_m:", "mm rms", "degrees (95 %)"]);
    is_found(&alignment(&bench.path("aligned.yaml")));
    bench.run("doctor --plant aligned.yaml --move").is(0, &["ok     tendon 4"]);
    // From a recording, measured with some other alignment.
    bench.run("weigh --plant aligned.yaml --weights 0 --out rest.csv").is(0, &[]);
    bench
        .run("align --plant aligned.yaml --measured rest.csv --static --out again.yaml")
        .is(0, &["mm rms"]);
    is_found(&alignment(&bench.path("again.yaml")));
    // And from a robot that moves.
    bench.put_commands("in.csv", 1, 60);
    bench.run("collect --plant aligned.yaml --commands in.csv --out moving.csv").is(0, &[]);
    bench
        .run("align --plant aligned.yaml --measured moving.csv --out moved.yaml")
        .is(0, &["mm rms"]);
    let apart = hidden().motion().inv_mul(&alignment(&bench.path("moved.yaml")).motion());
    assert!(apart.translation.vector.norm() < 0.01 && apart.rotation.angle() < 0.05, "{apart:?}");
}

/// A robot that bends further than the model in the same directions: the ratio is said, and the
/// frame found.
#[test]
fn a_robot_that_bends_further_is_aligned_and_the_ratio_is_said() {
    let bench = Bench::new();
    put_plant(&bench, &format!("{ROOT}/models/nominal.yaml"));
    let nominal = std::fs::read_to_string(format!("{ROOT}/models/nominal.yaml")).unwrap();
    bench.put("stiff.yaml", &nominal.replace("2.33e9", "6e9"));
    let plant =
        bench.text("plant.yaml").replacen(&format!("{ROOT}/models/nominal.yaml"), "stiff.yaml", 1);
    bench.put("plant.yaml", &plant);
    let ended = bench.run("align --plant plant.yaml --move --out aligned.yaml");
    ended.is(
        0,
        &[
            "the robot bends 1.7",
            "times as far as the model; directions agree within",
            "then align again",
        ],
    );
    let apart = hidden().motion().inv_mul(&alignment(&bench.path("aligned.yaml")).motion());
    let (m, rad) = (apart.translation.vector.norm(), apart.rotation.angle());
    assert!(m < 0.005 && rad < 0.05, "{m} m, {rad} rad: {}", ended.said);
}

#[test]
fn points_that_determine_nothing_are_refused() {
    let bench = Bench::new();
    put_plant(&bench, &format!("{ROOT}/models/nominal.yaml"));
    let header =
        "trial,time_s,tendon_1_m,tendon_2_m,tendon_3_m,tendon_4_m,tip_x_m,tip_y_m,tip_z_m\n";
    let refused = |name: &str, rows: &str, words: &str| {
        bench.put(name, &format!("{header}{rows}"));
        let ended = bench.run(&format!(
            "align --plant plant.yaml --measured {name} --static --out aligned.yaml"
        ));
        ended.is(2, &[&format!("error: {name}: "), words]);
        assert!(!bench.path("aligned.yaml").exists());
    };
    refused(
        "two.csv",
        "0,0,0,0,0,0,0,0,0.22\n0,1,0.01,0,-0.01,0,0.05,0,0.21\n",
        "2 points, expected at least 3",
    );
    let still = "0,0,0,0,0,0,0,0,0.22\n0,1,0,0,0,0,0,0,0.22\n0,2,0,0,0,0,0,0,0.22\n";
    refused("still.csv", still, "lie on a line");
    // Tips that go left where the model goes up: a mirror image, which no turn makes right.
    let pose = |k: usize, x: f64, y: f64, tip: [f64; 3]| {
        format!("0,{k},{x},{y},{},{},{},{},{}\n", -x, -y, tip[0], tip[1], tip[2])
    };
    let mirrored: String =
        [(0.01, 0.0), (0.0, 0.01), (-0.01, 0.0), (0.0, -0.01), (0.01, 0.01), (0.005, -0.01)]
            .iter()
            .enumerate()
            .map(|(k, (x, y))| {
                pose(k, *x, *y, [-5.0 * x, 5.0 * y, 0.5 * (x * 7.0 + y * 13.0).sin()])
            })
            .collect();
    refused("mirrored.csv", &mirrored, "no rotation and shift fits the measured tips");
    bench.run("align --plant plant.yaml").is(2, &["--measured"]);
}
