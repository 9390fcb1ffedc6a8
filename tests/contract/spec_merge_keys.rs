//! Merge keys and invisible characters in every kind of YAML that the program reads.

use spinebench::specs::{ExperimentSet, read_model, read_options, read_plant};
use std::path::Path;
use std::process::{Command, Output};

const ROD: &str = "{length_m: 0.22, radius_m: 0.002, youngs_modulus_pa: 2.33e9, poisson_ratio: \
                   0.3897, density_kg_m3: 1200}";
const TENDONS: &str =
    "  tendons: {radius_m: 0.020, angles_deg: [0, 90, 180, 270], pretension_m: 0.0005}\n";

fn put(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).unwrap();
}

fn simulate(folder: &Path, model: &str) -> Output {
    put(
        folder,
        "commands.csv",
        "trial,time_s,tendon_1_m,tendon_2_m,tendon_3_m,tendon_4_m\n0,0,0,0,0,0\n0,0.2,0.004,0,-0.004,0\n",
    );
    put(folder, "model.yaml", model);
    let mut command = Command::new(env!("CARGO_BIN_EXE_spinebench"));
    command.args(["simulate", "--static", "--model", "model.yaml", "--commands", "commands.csv"]);
    command.args(["--out", "out.csv"]).current_dir(folder).output().unwrap()
}

/// The tip of the last row, millimetres along x and z.
fn tip_mm(folder: &Path) -> [f64; 2] {
    let text = std::fs::read_to_string(folder.join("out.csv")).unwrap();
    let names: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let cells: Vec<&str> = text.lines().last().unwrap().split(',').collect();
    ["tip_x_m", "tip_z_m"].map(|name| {
        let place = names.iter().position(|column| *column == name).unwrap();
        1e3 * cells[place].parse::<f64>().unwrap()
    })
}

#[test]
fn a_model_with_a_merge_key_is_the_model_written_out() {
    let folder = tempfile::tempdir().unwrap();
    let model = format!("robot:\n  backbone:\n    <<: &rod {ROD}\n    length_m: 0.30\n{TENDONS}");
    let output = simulate(folder.path(), &model);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for (found, expected) in tip_mm(folder.path()).into_iter().zip([28.165, 297.659]) {
        assert!((found - expected).abs() < 1e-3, "{found} {expected}");
    }
}

#[test]
fn errors_in_merged_keys_point_to_where_they_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let model = format!(
        "x: &rod\n  radius_m: thick\nrobot:\n  backbone:\n    <<: *rod\n    length_m: 0.30\n{TENDONS}"
    );
    put(folder.path(), "model.yaml", &model);
    let said = read_model(&folder.path().join("model.yaml")).unwrap_err().to_string();
    assert!(said.contains("model.yaml:2:13: robot.backbone.radius_m: found text"), "{said}");
    put(folder.path(), "model.yaml", "robot:\n  backbone:\n    <<: 3\n");
    let said = read_model(&folder.path().join("model.yaml")).unwrap_err().to_string();
    assert!(
        said.contains("model.yaml:3:9: robot.backbone.<<: found 3, expected a mapping, or a list"),
        "{said}"
    );
}

#[test]
fn specs_plants_and_options_read_merge_keys() {
    let folder = tempfile::tempdir().unwrap();
    let smoke = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/smoke.yaml");
    let spec = format!(
        "extends: {}\nexplore: {{<<: {{points: 500, trajectories: 3}}, points: 300}}\n",
        smoke.display()
    );
    put(folder.path(), "spec.yaml", &spec);
    let read = ExperimentSet::read(&folder.path().join("spec.yaml"), &[], &[]).unwrap();
    assert_eq!((read.experiment.explore.points, read.experiment.explore.trajectories), (300, 3));
    let model = format!("robot:\n  backbone: {ROD}\n{TENDONS}");
    put(folder.path(), "model.yaml", &model);
    put(folder.path(), "plant.yaml", "simulated: {<<: [{noise_m: 1e-3}], model: model.yaml}\n");
    let plant = read_plant(&folder.path().join("plant.yaml")).unwrap();
    assert_eq!(plant.noise_m(), Some(1e-3));
    put(folder.path(), "options.yaml", "<<: {no_such_key: 1}\n");
    let said = read_options(&folder.path().join("options.yaml")).unwrap_err().to_string();
    assert!(said.contains("options.yaml:1:6: no_such_key: found the unknown key"), "{said}");
}

#[test]
fn invisible_characters_are_named_with_their_line() {
    let folder = tempfile::tempdir().unwrap();
    for (model, expected) in [
        (
            format!(
                "robot:\n  backbone:\n    {ROD}\n  tendons: {{radius_m:\u{a0}0.020, angles_deg: [0]}}\n"
            ),
            "model.yaml:4:13: robot.tendons: found a no-break space (U+00A0) after `radius_m:`, \
             expected keys and values of visible characters",
        ),
        (
            format!(
                "robot:\n  backbone: {ROD}\n  tendons:\n    radius_m:\u{a0}0.020\n    angles_deg: [0]\n"
            ),
            "model.yaml:4:14: found a no-break space (U+00A0) after `radius_m:`, expected YAML",
        ),
        (
            format!(
                "robot:\n  backbone: {ROD}\n  tendons: {{radius_m: 0.020\u{200b}, angles_deg: [0]}}\n"
            ),
            "model.yaml:3:23: robot.tendons.radius_m: found text \"0.020\u{200b}\", with a zero-width \
             space (U+200B) after `0.020`, expected",
        ),
        (
            format!(
                "robot:\n  backbone: {ROD}\n  {}\u{feff}disks: {{count: 3}}\n",
                TENDONS.trim_start()
            ),
            "model.yaml:4:1:",
        ),
    ] {
        let output = simulate(folder.path(), &model);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.starts_with(&format!("error: {expected}")), "{said}\n{expected}");
        assert!(said.contains("(U+"), "{said}");
    }
}
