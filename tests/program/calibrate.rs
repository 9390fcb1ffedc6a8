//! `calibrate` through the program itself: paths, held-out patterns, the report, and what is
//! refused.

use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Output};

const NOMINAL: &str = include_str!("../../models/nominal.yaml");

/// A folder with a truth, a guess and a recording of the truth: poses at rest of six patterns, tip
/// and one more point.
struct Laboratory(tempfile::TempDir);

impl Laboratory {
    fn new() -> Laboratory {
        let lab = Laboratory(tempfile::tempdir().unwrap());
        let tracking = "tracking: {points: {middle: {s_m: 0.11, offset_m: [0, 0, 0.003]}}}\n";
        let guess = format!("{NOMINAL}{tracking}");
        let truth =
            guess.replace("2.33e9", "2.1e9").replace("[0, 90, 180, 270]", "[4, 90, 180, 270]");
        let truth = truth.replace("s_m: 0.11,", "s_m: 0.105,");
        assert!(
            truth.contains("2.1e9") && truth.contains("[4, 90"),
            "the nominal model has changed"
        );
        lab.put("guess.yaml", &guess);
        lab.put("truth.yaml", &truth);
        let mut commands =
            String::from("trial,time_s,tendon_1_m,tendon_2_m,tendon_3_m,tendon_4_m,pattern\n");
        for row in 0..48 {
            let (pattern, angle) = (row / 8, f64::from(row) * 0.9);
            let [x, y] =
                [angle.cos(), angle.sin()].map(|part| 0.002 * f64::from(pattern + 1) * part);
            writeln!(commands, "0,{row},{x},{y},{},{},kind_{pattern}", -x, -y).unwrap();
        }
        lab.put("commands.csv", &commands);
        lab.ok(&[
            "simulate",
            "--static",
            "--model",
            "truth.yaml",
            "--commands",
            "commands.csv",
            "--out",
            "rec.csv",
        ]);
        lab
    }

    fn put(&self, name: &str, text: &str) {
        std::fs::write(self.0.path().join(name), text).unwrap();
    }

    fn run(&self, arguments: &[&str]) -> Output {
        let program = Path::new(env!("CARGO_BIN_EXE_spinebench"));
        Command::new(program).args(arguments).current_dir(self.0.path()).output().unwrap()
    }

    fn ok(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {said}");
        String::from_utf8(output.stdout).unwrap()
    }

    fn calibrate(&self, more: &[&str]) -> Output {
        let files = [
            "calibrate",
            "--static",
            "--model",
            "guess.yaml",
            "--measured",
            "rec.csv",
            "--out",
            "out.yaml",
        ];
        self.run(&[&files, more].concat())
    }

    fn refused(&self, more: &[&str]) -> String {
        let output = self.calibrate(more);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{more:?}: {said}");
        assert!(!self.0.path().join("out.yaml").exists(), "{more:?} wrote a model");
        said
    }
}

const FIT: &str = "youngs_modulus_pa,robot.tendons.angles_deg[0],tracking.points.middle.s_m";

#[test]
fn numbers_by_path_come_back_and_unseen_patterns_tell_how_good_the_model_is() {
    let lab = Laboratory::new();
    let output =
        lab.calibrate(&["--fit", FIT, "--hold-out-patterns", "kind_5", "--report", "report"]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}{}", String::from_utf8_lossy(&output.stderr));
    let folder = lab.0.path().join("report");
    let found: Value =
        serde_json::from_str(&std::fs::read_to_string(folder.join("calibration.json")).unwrap())
            .unwrap();
    for (number, truth) in found["numbers"].as_array().unwrap().iter().zip([2.1e9, 4.0, 0.105]) {
        let value = number["value"].as_f64().unwrap();
        assert!((value - truth).abs() < 1e-4 * truth, "{number}");
    }
    assert_eq!(found["held_out"]["names"], serde_json::json!(["kind_5"]));
    assert_eq!(found["positions"], 80, "two points in 40 rows");
    let models = found["held_out"]["models"].as_array().unwrap();
    let rms_m = |name: &str| {
        models.iter().find(|model| model["name"] == name).unwrap()["rms_m"].as_f64().unwrap()
    };
    assert!(
        rms_m("this model, fitted") < 1e-6 && rms_m("this model, as given") > 1e-3,
        "{models:?}"
    );
    for other in
        ["constant curvature", "linear regression", "quadratic regression", "Gaussian process"]
    {
        assert!(rms_m(other) > 1e-4 && rms_m(other) < 0.1, "{other}: {models:?}");
    }
    for file in [
        "report.html",
        "errors.svg",
        "map.png",
        "numbers.csv",
        "residuals.csv",
        "residual_groups.csv",
    ] {
        assert!(folder.join(file).exists(), "{file}");
    }
    let model = spinebench::specs::read_model(&lab.0.path().join("out.yaml")).unwrap();
    assert!(
        (model.robot.tendons.angles_deg[0] - 4.0).abs() < 1e-3
            && model.robot.tendons.angles_deg[1] == 90.0
    );
}

#[test]
fn several_recordings_are_fitted_together_each_with_its_own_load() {
    let lab = Laboratory::new();
    let commands = std::fs::read_to_string(lab.0.path().join("commands.csv")).unwrap();
    let hung = |(number, row): (usize, &str)| {
        format!("{row},{}\n", if number == 0 { "known_load_kg" } else { "0.1" })
    };
    lab.put("hung.csv", &commands.lines().enumerate().map(hung).collect::<String>());
    let files = ["--model", "truth.yaml", "--commands", "hung.csv", "--out", "weighed.csv"];
    lab.ok(&[&["simulate", "--static"], &files[..]].concat());
    let both = ["--static", "--model", "guess.yaml", "--measured", "rec.csv", "weighed.csv"];
    let held = ["--fit", FIT, "--hold-out-patterns", "weighed/kind_*", "--out", "out.yaml"];
    lab.ok(&[&["calibrate"], &both[..], &held, &["--report", "report"]].concat());
    let text = std::fs::read_to_string(lab.0.path().join("report/calibration.json")).unwrap();
    let found: Value = serde_json::from_str(&text).unwrap();
    let names = found["held_out"]["names"].as_array().unwrap();
    assert!(names.len() == 6 && names.contains(&"weighed/kind_3".into()), "{names:?}");
    // The weight is known, so that a fit without it predicts the recording with it.
    assert!(found["held_out"]["models"][0]["rms_m"].as_f64().unwrap() < 1e-6, "{found}");
    lab.ok(&[&["calibrate"], &both[..], &["--out", "out.yaml", "--report", "report"]].concat());
    let text = std::fs::read_to_string(lab.0.path().join("report/residual_groups.csv")).unwrap();
    assert!(text.contains("recording,weighed,") && text.contains("pattern,rec/kind_0,"), "{text}");
    let again = ["calibrate", "--static", "--model", "guess.yaml", "--out", "again.yaml"];
    let output = lab.run(&[&again, &["--measured", "rec.csv", "rec.csv"][..]].concat());
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(2) && said.contains("another recording"), "{said}");
}

#[test]
fn what_cannot_be_fitted_is_refused_with_what_was_meant() {
    let lab = Laboratory::new();
    let words = |fit: &str| lab.refused(&["--fit", fit]);
    assert!(words("robot.backbone.youngs_modulus").contains("`robot.backbone.youngs_modulus_pa`"));
    assert!(words("robot.disks.count").contains("a whole number"));
    assert!(words("robot.tendons.angles_deg").contains("`robot.tendons.angles_deg[*]`"));
    assert!(words("robot.backbone.length_m~0").contains("above 0"));
    assert!(lab.refused(&["--hold-out-patterns", "circle"]).contains("kind_0, kind_1"));
    assert!(lab.refused(&["--hold-out", "1.5"]).contains("between 0 and 1"));
    let rows = std::fs::read_to_string(lab.0.path().join("rec.csv")).unwrap();
    let few: Vec<&str> = rows.lines().take(3).collect();
    lab.put("rec.csv", &few.join("\n"));
    assert!(
        words("tendons.*,backbone.*,base_*")
            .contains("tracked positions: found 4, expected at least")
    );
    let guess = std::fs::read_to_string(lab.0.path().join("guess.yaml")).unwrap();
    // A modulus in another unit: the model cannot follow, and its key is named.
    lab.put(
        "guess.yaml",
        &guess.replacen("youngs_modulus_pa: 2.33e9", "youngs_modulus_pa: 8e3", 1),
    );
    let soft = words("tendons.radius_m");
    assert!(soft.contains("cannot simulate these commands"), "{soft}");
    assert!(soft.contains("guess.yaml: robot.backbone.youngs_modulus_pa: found 8000"), "{soft}");
    let piece = "pieces: [{end_m: 0.22, bending_stiffness_n_m2: 0.03, axial_stiffness_n: 1e4, \
                 shear_stiffness_n: 1e4, torsion_stiffness_n_m2: 0.02}], length_m: 0.22";
    lab.put("guess.yaml", &guess.replacen("length_m: 0.22", piece, 1));
    assert!(
        words("youngs_modulus_pa").contains("`robot.backbone.pieces[*].bending_stiffness_n_m2`")
    );
}
