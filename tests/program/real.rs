//! `make real`: the converters of published files, what it says without them, and the published
//! models.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use spinebench::league::measured::measured_robots;
use spinebench::league::track::ReadTrack;
use spinebench::specs::read_model;

const ROBOTS: [&str; 4] = ["v4", "v6", "trunk", "tentacle"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Runs Python at the root of the repository, with the modules of `benches/real`.
fn python(code: &str, arguments: &[&Path]) -> Output {
    let code = format!("import sys; sys.path.insert(0, 'benches/real'); import convert\n{code}");
    Command::new("python3")
        .arg("-B")
        .arg("-c")
        .arg(code)
        .args(arguments)
        .current_dir(root())
        .output()
        .unwrap()
}

/// Code that converts the files named by all arguments but the last one, into that.
fn converter(of: &str) -> String {
    format!("convert.{of}(sys.argv[1:-1], sys.argv[-1])")
}

/// Rows of a CSV file without quotes.
fn rows(path: &Path) -> Vec<HashMap<String, String>> {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let row = |line: &str| {
        header
            .iter()
            .map(|name| (*name).to_owned())
            .zip(line.split(',').map(str::to_owned))
            .collect()
    };
    lines.map(row).collect()
}

fn number(row: &HashMap<String, String>, name: &str) -> f64 {
    row[name].parse().unwrap_or(f64::NAN)
}

/// The folder of the measured files, where it is.
fn real_data() -> Option<PathBuf> {
    let folder = std::env::var_os("REAL_DATA")
        .map_or_else(|| root().join("../shared/recordings"), PathBuf::from);
    let there = folder.join("opencr/v4_train.csv").is_file();
    if !there {
        println!("skipped: {} has no measured files of others", folder.display());
    }
    there.then_some(folder)
}

/// Made-up rows in the form of each laboratory's files, and what becomes of them.
#[test]
fn published_files_become_recordings() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let ftdcr = "timestamp,pattern_label,servo_4_mm,servo_3_mm,tip_x,tip_y,tip_z\n\
                 100.5,rep1_seg1_dir0,0.5,-1.25,10,20,30\n100.5,rep1_seg1_dir0_hold,1,2,11,21,31\n";
    std::fs::write(path("ftdcr.csv"), ftdcr).unwrap();
    let kept_apart = ftdcr.replace("rep1_seg1", "rep1_all");
    std::fs::write(path("kept_apart.csv"), kept_apart).unwrap();
    let files = [path("ftdcr.csv"), path("kept_apart.csv"), path("out.csv")];
    let done = python(&converter("ftdcr"), &files.each_ref().map(PathBuf::as_path));
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let found = rows(&path("out.csv"));
    let kept_apart = [&found[2]["trial"], &found[2]["pattern"]];
    assert_eq!(kept_apart, ["1", "val_rep1_all_dir0"], "rows that were kept apart judge");
    assert_eq!((number(&found[0], "tendon_2_m"), number(&found[0], "tip_z_m")), (-0.00125, 0.03));
    assert!(
        number(&found[1], "time_s") > number(&found[0], "time_s"),
        "equal times are kept apart"
    );
    assert_eq!(found[1]["pattern"], "rep1_seg1_dir0", "the rest belongs to the motion");

    let mut trunk = String::from("t,phi1,phi2,phi3,phi4,phi5,phi6,x1,y1,z1,x2,y2,z2,x3,y3,z3\n");
    for k in 0..8 {
        trunk += &format!("{},180,0,0,0,0,-90,1,-2,3,4,-5,6,7,-8,9\n", 20 * k);
    }
    std::fs::write(path("trunk.csv"), trunk).unwrap();
    assert!(python(&converter("trunk"), &[&path("trunk.csv"), &path("out.csv")]).status.success());
    let found = rows(&path("out.csv"));
    assert_eq!(
        (found.len(), found[0]["pattern"].as_str(), found[1]["pattern"].as_str()),
        (2, "early", "late")
    );
    let angles = [1, 6].map(|servo| number(&found[0], &format!("drive_servo_{servo}_rad")));
    let right = [std::f64::consts::PI, -std::f64::consts::FRAC_PI_2];
    assert!(
        angles.iter().zip(right).all(|(found, right)| (found - right).abs() < 1e-7),
        "{angles:?}"
    );
    let tip = ["x", "y", "z"].map(|axis| number(&found[0], &format!("tip_{axis}_m")));
    assert_eq!(tip, [7.0, 9.0, 8.0], "the tracker's y points up");

    let tentacle = "file,pb_x,pb_y,pb_z,p1_x,p1_y,p1_z,p2_x,p2_y,p2_z,p3_x,p3_y,p3_z,p4_x,p4_y,p4_z\n\
                    m2_u025.csv,0,0,0,0.1,0.2,0.3,0,0,0,0,0,0,0,0,0\nm12_u0020015.csv,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0\n";
    std::fs::write(path("tentacle.csv"), tentacle).unwrap();
    assert!(
        python(&converter("tentacle"), &[&path("tentacle.csv"), &path("out.csv")]).status.success()
    );
    let found = rows(&path("out.csv"));
    let tension = |row: usize| {
        [1, 2].map(|k| (number(&found[row], &format!("tendon_{k}_n")) * 0.0325 * 1e4).round())
    };
    assert_eq!([tension(0), tension(1)], [[0.0, 2500.0], [2000.0, 1500.0]]);
    let marker = ["x", "y", "z"].map(|axis| number(&found[0], &format!("point_p1_{axis}_m")));
    assert_eq!(marker, [0.3, 0.13, 0.213]);
}

#[test]
fn without_the_measured_files_it_says_who_publishes_them() {
    let empty = tempfile::tempdir().unwrap();
    let setting = format!("REAL_DATA={}", empty.path().display());
    let done = Command::new("make").args(["real", &setting]).current_dir(root()).output().unwrap();
    let said = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(2), "{said}");
    for words in [
        setting.as_str(),
        "opencr/v4_train.csv",
        "https://github.com/ContinuumRoboticsLab/opencr-mujoco, revision 17fff8b: \
         data/sysid/ftdcr_v4/",
        "https://github.com/StanfordASL/trunk-stack, revision 8b4b9234",
        "https://github.com/tud-phi/soromox, revision 4f03054a",
        "MIT licence",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    assert_eq!(std::fs::read_dir(empty.path()).unwrap().count(), 0);
}

/// The league refuses other rows than those that `--convert` writes.
#[test]
fn the_league_expects_the_files_that_convert_writes() {
    let Some(data) = real_data() else { return };
    let out = tempfile::tempdir().unwrap();
    let mut convert = Command::new("python3");
    convert.args(["-B", "benches/real/real.py", "--convert"]).arg(&data).arg(out.path());
    let done = convert.current_dir(root()).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let track = ReadTrack::read(&root().join("experiments/league"), "identify").unwrap();
    let robots = measured_robots(&track, out.path()).unwrap();
    let names: Vec<&str> = robots.iter().map(|robot| robot.name.as_str()).collect();
    assert_eq!(names, ["tentacle", "trunk", "v4", "v6"]);
    for robot in robots {
        let question = robot.measured.unwrap();
        assert_eq!(question.asked.len(), question.tips_m.len());
        println!(
            "{}: {} rows given, {} asked",
            robot.name,
            question.given.len(),
            question.asked.len()
        );
    }
}

/// The models are read; with the measured files, they predict the rows that were held out, or all
/// that were fitted where none were, as well as was published.
#[test]
fn published_models_predict_as_published() {
    for robot in ROBOTS {
        read_model(&root().join(format!("models/real/{robot}.yaml"))).unwrap();
    }
    let Some(data) = real_data() else { return };
    let work = tempfile::tempdir().unwrap();
    for (robot, file, converter) in [
        ("v4", "opencr/v4_train.csv", "ftdcr"),
        ("v6", "opencr/v6_train.csv", "ftdcr"),
        ("trunk", "trunk/0g.csv", "trunk"),
    ] {
        let [measured, simulated] =
            ["measured", "simulated"].map(|what| work.path().join(format!("{robot}_{what}.csv")));
        assert!(
            python(&self::converter(converter), &[&data.join(file), &measured]).status.success()
        );
        let model = root().join(format!("models/real/{robot}.yaml"));
        let done = Command::new(env!("CARGO_BIN_EXE_spinebench"))
            .args(["simulate", "--static", "--model"])
            .arg(&model)
            .arg("--commands")
            .arg(&measured)
            .arg("--out")
            .arg(&simulated)
            .output()
            .unwrap();
        assert!(done.status.success(), "{robot}: {}", String::from_utf8_lossy(&done.stderr));
        let found =
            std::fs::read_to_string(root().join(format!("results/real/{robot}/calibration.json")))
                .unwrap();
        let found: serde_json::Value = serde_json::from_str(&found).unwrap();
        let held = &found["held_out"];
        let names: Vec<&str> =
            held["names"].as_array().unwrap().iter().filter_map(|name| name.as_str()).collect();
        let published =
            if names.is_empty() { &found["after_m"] } else { &held["models"][0]["rms_m"] };
        let published_m = published.as_f64().unwrap();
        let rms_m = self::rms_m(&rows(&measured), &rows(&simulated), &names);
        println!("{robot}: {:.3} mm, published {:.3} mm", 1e3 * rms_m, 1e3 * published_m);
        assert!(
            (rms_m - published_m).abs() < 0.02e-3,
            "{robot}: {rms_m} m, published {published_m} m"
        );
    }
}

/// Root mean square distance of every tracked point in the rows of some patterns; of all without a
/// name.
fn rms_m(
    measured: &[HashMap<String, String>],
    simulated: &[HashMap<String, String>],
    names: &[&str],
) -> f64 {
    let points: Vec<&str> =
        measured[0].keys().filter_map(|name| name.strip_suffix("_x_m")).collect();
    let mut squares = Vec::new();
    let is_judged = |row: &HashMap<String, String>| {
        names.is_empty() || names.contains(&row["pattern"].as_str())
    };
    for (row, model) in measured.iter().zip(simulated).filter(|(row, _)| is_judged(row)) {
        for point in &points {
            let error = ["x", "y", "z"].map(|axis| {
                let name = format!("{point}_{axis}_m");
                number(row, &name) - number(model, &name)
            });
            squares.push(error.iter().map(|e| e * e).sum::<f64>());
        }
    }
    squares.retain(|square| square.is_finite());
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}
