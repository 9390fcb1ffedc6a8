//! The recording format: what goes out comes back, and what is wrong is said with file, place,
//! column and expectation.

use std::fs;
use std::path::{Path, PathBuf};

use proptest::prelude::*;
use spinebench::base::Rows;
use spinebench::data::recording::{Extra, PointTrack, Pose, RecordedWrench};
use spinebench::data::{Actuation, DataError, Recording};

const GOOD: &str = "\
trial,time_s,tendon_1_m,tendon_2_m,tendon_3_m,tendon_4_m,tip_x_m,tip_y_m,tip_z_m
0,0.000,0.000000,0.000000,0.000000,0.000000,-0.013140,0.000145,0.218688
0,0.200,0.001210,-0.001931,-0.001210,0.001931,-0.012290,-0.000481,0.218833
1,0.000,0.000000,0.000000,0.000000,0.000000,-0.013140,0.000145,0.218688
";

fn read(text: &str) -> Result<Recording, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rec.csv");
    fs::write(&path, text).unwrap();
    // The folder's name is chance; the message is compared without it.
    let shorten =
        |error: DataError| error.to_string().replace(&format!("{}/", folder.path().display()), "");
    Recording::read(&path).map_err(shorten)
}

/// A recording with every optional column.
fn full(rows: usize) -> Recording {
    let mut recording = Recording::new(Actuation::Lengths, 3);
    let wave = |row: usize, part: usize| ((row * 7 + part) as f64 * 0.37).sin() / 3.0;
    for row in 0..rows {
        recording.trial.push((row / 2) as u64);
        recording.time_s.push((row % 2) as f64 * 0.1);
        recording.commands.push(&[wave(row, 0) * 1e-2, 0.1 + 0.2, 1e-7]);
    }
    let each = |part| (0..rows).map(move |row| wave(row, part));
    recording.tip_m = Some(each(1).map(|x| [x, -x, 0.22]).collect());
    recording.tip_quaternion = Some(each(2).map(|x| [x.cos(), x.sin(), 0.0, 0.0]).collect());
    let pose = |x: f64| Pose { position_m: [x, 0.0, 1e-300], quaternion: [1.0, 0.0, 0.0, 0.0] };
    recording.base = Some(each(3).map(pose).collect());
    recording.known_load_kg = Some(each(4).map(f64::abs).collect());
    recording.valid = Some((0..rows).map(|row| row % 3 != 1).collect());
    let load = |x: f64| RecordedWrench { force_n: [x, 0.0, 0.0], moment_nm: [0.0, x, 0.0] };
    recording.tip_load = Some(each(5).map(load).collect());
    let track = |name: &str, part: usize, turned: bool| PointTrack {
        name: name.to_owned(),
        position_m: each(part).map(|x| [x, 0.1, -x]).collect(),
        quaternion: turned.then(|| each(part).map(|x| [0.0, x.cos(), x.sin(), 0.0]).collect()),
    };
    recording.points = vec![track("disk_1", 6, true), track("x_m", 7, false)];
    recording.pattern =
        Some((0..rows).map(|row| ["one tendon", "all"][row % 2].to_owned()).collect());
    let words = (0..rows).map(|row| format!("said \"{row}\", then left")).collect();
    recording.extra = vec![("note".to_owned(), Extra::Text(words))];
    recording
}

#[test]
fn a_trial_may_be_written_as_a_float_if_it_is_whole() {
    let floats = GOOD.replace("\n0,", "\n0.0,").replace("\n1,", "\n1.000e+00,");
    assert_eq!(read(&floats), read(GOOD));
    for wrong in ["0.5", "-1.0", "nan", "1e300"] {
        let message = read(&GOOD.replace("\n1,", &format!("\n{wrong},"))).unwrap_err();
        assert!(message.contains("line 4") && message.contains("trial number"), "{message}");
    }
}

#[test]
fn the_contracts_sample_is_read() {
    let recording = read(GOOD).unwrap();
    assert_eq!(
        (recording.len(), recording.tendons(), recording.actuation),
        (3, 4, Actuation::Lengths)
    );
    assert_eq!(recording.trials(), [(0, 0..2), (1, 2..3)]);
    assert_eq!(recording.commands.row(1), [0.00121, -0.001931, -0.00121, 0.001931]);
    assert_eq!(recording.tip_m.as_ref().unwrap()[1], [-0.01229, -0.000481, 0.218833]);
    let with_marks = format!("\u{feff}{}", GOOD.replace('\n', "\r\n"));
    assert_eq!(read(&with_marks).unwrap(), recording, "CRLF and a byte order mark change nothing");
}

#[test]
fn every_column_survives_both_formats() {
    let folder = tempfile::tempdir().unwrap();
    let written = full(7);
    for name in ["rec.csv", "rec.parquet"] {
        let path = folder.path().join(name);
        written.write(&path).unwrap();
        assert_eq!(Recording::read(&path).unwrap(), written, "{name}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "no temporary file is left");
}

#[test]
fn parquet_carries_numbers_as_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rec.parquet");
    let mut written = full(4);
    written.extra = vec![
        ("solver_iterations".to_owned(), Extra::Integers(vec![3, 4, 3, 5])),
        ("tension_1_n".to_owned(), Extra::Numbers(vec![0.5, 1e-17, 3.0, -0.25])),
    ];
    written.write(&path).unwrap();
    assert_eq!(Recording::read(&path).unwrap(), written);
}

#[test]
fn tensions_and_lost_tracking() {
    let text = "trial,time_s,tendon_1_n,tip_x_m,tip_y_m,tip_z_m,valid\n0,0,1.5,0,0,0.2,1\n0,0.2,2.5,,NaN,,0\n";
    let recording = read(text).unwrap();
    assert_eq!(recording.actuation, Actuation::Tensions);
    assert_eq!(recording.commands.values(), [1.5, 2.5]);
    assert!(recording.is_valid(0) && !recording.is_valid(1));
    assert!(recording.tip_m.unwrap()[1].iter().all(|part| part.is_nan()));
}

#[test]
fn commands_need_no_tip() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("commands.csv");
    fs::write(&path, "trial,time_s,tendon_1_m,tendon_2_m\n0,0,0,0\n0,0.2,0.001,-0.001\n").unwrap();
    let commands = Recording::read_commands(&path).unwrap();
    assert_eq!((commands.tip_m.clone(), commands.len()), (None, 2));
    assert!(Recording::read(&path).unwrap_err().to_string().contains("`tip_x_m`"));
    let copy = folder.path().join("copy.csv");
    commands.write(&copy).unwrap();
    assert_eq!(Recording::read_commands(&copy).unwrap(), commands);
}

#[test]
fn faults_are_named_with_line_column_found_and_expected() {
    let cell = |from: &str, to: &str| GOOD.replacen(from, to, 1);
    let cases = [
        (cell("-0.012290", "NaN"), "line 3, column `tip_x_m`: found `NaN`, expected a number"),
        (cell("-0.012290", ""), "line 3, column `tip_x_m`: found nothing, expected a number"),
        (cell("0.001210", "two"), "line 3, column `tendon_1_m`: found `two`, expected metres"),
        (cell("0.001210", "inf"), "line 3, column `tendon_1_m`: found `inf`, expected metres"),
        (cell("0,0.200", "0,-0.1"), "line 3, column `time_s`: found `-0.1`, expected more than 0"),
        (
            cell("0,0.200", "0,0.000"),
            "line 3, column `time_s`: found `0.000`, expected more than 0",
        ),
        (
            cell("1,0.000", "1,0.200"),
            "line 4, column `time_s`: found `0.200`, expected 0 at the start of trial 1",
        ),
        (
            cell("0,0.200", "-1,0.200"),
            "line 3, column `trial`: found `-1`, expected a trial number",
        ),
        (cell("0,0.200", "2.5,0"), "line 3, column `trial`: found `2.5`, expected a trial number"),
        (cell(",0.218833", ""), "line 3: found 8 cells, expected 9"),
        (cell("0.218833", "0.218833,7"), "line 3: found 10 cells, expected 9"),
        (cell("0.218833", "\"0.218833"), "line 3: found a quotation mark that is not closed"),
        (cell("\n0,0.2", "\n\n0,0.2"), "line 3: found an empty line"),
        (
            cell("time_s", "time"),
            "rec.csv, line 1, column `time_s`: found only trial, time, tendon_1_m",
        ),
        (cell("tip_y_m", "tip_y_mm"), "expected a column `tip_y_m`"),
        (
            cell("time_s", "t").replacen("tip_y_m,tip_z_m", "y,z", 1),
            "rec.csv, line 1, column `time_s`: found only trial, t, tendon_1_m, tendon_2_m, \
             tendon_3_m, tendon_4_m, tip_x_m, y, z, expected the columns `time_s`, `tip_y_m`, \
             `tip_z_m`",
        ),
        (
            cell("tendon_1_m", "tendon_9_m").replacen("tip_x_m", "base_x_m", 1),
            "expected the columns `tendon_1_m`, `tendon_5_m`, `tendon_6_m`, `tendon_7_m`, \
             `tendon_8_m`, `tip_x_m`, `base_y_m`, `base_z_m`, `base_qw`, `base_qx`, `base_qy`, \
             `base_qz`",
        ),
        (cell("tendon_2_m", "tendon_5_m"), "expected a column `tendon_2_m`"),
        (
            cell("tendon_2_m", "tendon_1_m"),
            "column `tendon_1_m`: found a second column of this name",
        ),
        (cell("tendon_2_m", "tendon_2_n"), "found commands as lengths and as tensions"),
        (cell("tip_y_m", ""), "found no name for column 8"),
        (
            format!("{GOOD}0,0.4,0,0,0,0,0,0,0.2\n"),
            "line 5, column `trial`: found `0`, expected a new trial",
        ),
        (String::new(), "rec.csv: empty: found no header"),
        (GOOD.lines().next().unwrap().to_owned(), "rec.csv: empty: found a header and no rows"),
    ];
    for (text, expected) in cases {
        let error = read(&text).expect_err(expected);
        assert!(
            error.starts_with("rec.csv") && error.contains(expected),
            "{error}\n  does not say: {expected}"
        );
    }
}

#[test]
fn optional_groups_come_whole_and_plausible() {
    let with = |names: &str, cells: &str| {
        let mut lines = GOOD.lines();
        let header = format!("{},{names}", lines.next().unwrap());
        let rows: Vec<String> = lines.map(|line| format!("{line},{cells}")).collect();
        read(&format!("{header}\n{}\n", rows.join("\n")))
    };
    assert!(with("tip_qw,tip_qx,tip_qy,tip_qz", "1,0,0,0").unwrap().tip_quaternion.is_some());
    let cases = [
        (with("tip_qw,tip_qx,tip_qy", "1,0,0"), "expected a column `tip_qz`"),
        (with("tip_qw,tip_qx,tip_qy,tip_qz", "1,1,0,0"), "expected a unit quaternion"),
        (
            with("base_x_m,base_y_m,base_z_m", "0,0,0"),
            "expected the columns `base_qw`, `base_qx`, `base_qy`, `base_qz`",
        ),
        (
            with("base_qw,base_qx,base_qy,base_qz", "1,0,0,0"),
            "expected the columns `base_x_m`, `base_y_m`, `base_z_m`",
        ),
        (
            with("known_load_kg", "-0.02"),
            "line 2, column `known_load_kg`: found `-0.02`, expected kilograms",
        ),
        (with("valid", "yes"), "line 2, column `valid`: found `yes`, expected 1, or 0"),
        (
            with("tip_force_x_n", "1"),
            "expected the columns `tip_force_y_n`, `tip_force_z_n`, `tip_moment_x_nm`",
        ),
    ];
    for (result, expected) in cases {
        let error = result.expect_err(expected);
        assert!(error.contains(expected), "{error}\n  does not say: {expected}");
    }
}

#[test]
fn faults_of_parquet_are_named_by_row() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rec.parquet");
    let mut written = full(4);
    written.time_s[3] = -1.0;
    written.write(&path).unwrap();
    let error = Recording::read(&path).unwrap_err().to_string();
    assert!(error.contains("row 4, column `time_s`: found -1, expected more than 0"), "{error}");
}

#[test]
fn files_that_are_not_tables() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rec.csv");
    assert!(matches!(Recording::read(&path), Err(DataError::Read { .. })));
    fs::write(&path, b"trial,time_s\n0,\xff\n").unwrap();
    assert!(
        Recording::read(&path)
            .unwrap_err()
            .to_string()
            .contains("line 2: found bytes that are not text")
    );
    fs::write(&path, b"PAR1 and then nothing of the kind").unwrap();
    assert!(matches!(Recording::read(&path), Err(DataError::Read { .. })));
}

#[test]
fn millimetres_are_noticed() {
    let recording = read(&GOOD.replace("0.218833", "218.833")).unwrap();
    assert_eq!(read(GOOD).unwrap().check_reach(Path::new("rec.csv"), [0.0; 3], 0.22), Ok(()));
    let error =
        recording.check_reach(Path::new("rec.csv"), [0.0; 3], 0.22).unwrap_err().to_string();
    assert!(error.contains("line 3, column `tip_z_m`: found 218.833"), "{error}");
    let bench =
        read(&GOOD.replace("0.218833", "1.218833").replace("0.218688", "1.218688")).unwrap();
    assert!(bench.check_reach(Path::new("rec.csv"), [0.0; 3], 0.22).is_err());
    assert_eq!(
        bench.check_reach(Path::new("rec.csv"), [0.0, 0.0, 1.0], 0.22),
        Ok(()),
        "a real robot"
    );
}

/// What a file begins with tells where its rows stand; its name need not.
#[test]
fn a_misnamed_file_is_told_about_as_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let [parquet, misnamed] = ["rec.parquet", "rec.csv"].map(|name| folder.path().join(name));
    let mut written = full(4);
    written.tip_m.as_mut().unwrap()[2][0] = 218.8;
    written.write(&parquet).unwrap();
    fs::rename(parquet, &misnamed).unwrap();
    let read = Recording::read(&misnamed).unwrap();
    let error = read.check_reach(&misnamed, [0.0; 3], 0.22).unwrap_err().to_string();
    assert!(error.contains("rec.csv, row 3, column `tip_x_m`: found 218.8"), "{error}");
}

#[test]
fn a_bad_recording_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path: PathBuf = folder.path().join("rec.csv");
    let mut recording = full(4);
    recording.known_load_kg = Some(vec![0.0]);
    assert!(matches!(recording.write(&path), Err(DataError::Write { .. })));
    assert!(!path.exists());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn all_digits_survive(values in prop::collection::vec(prop::num::f64::NORMAL | prop::num::f64::ZERO, 1..40)) {
        let folder = tempfile::tempdir().unwrap();
        let mut recording = Recording::new(Actuation::Tensions, 1);
        let mut commands = Rows::new(1);
        for (row, &value) in values.iter().enumerate() {
            recording.trial.push(row as u64);
            recording.time_s.push(0.0);
            commands.push(&[value]);
        }
        recording.commands = commands;
        for name in ["rec.csv", "rec.parquet"] {
            let path = folder.path().join(name);
            recording.write(&path).unwrap();
            prop_assert_eq!(&Recording::read_commands(&path).unwrap(), &recording);
        }
    }
}

const POINTS: &str = "\
trial,time_s,tendon_1_m,point_a_x_m,point_a_y_m,point_a_z_m,point_b_x_m,point_b_y_m,point_b_z_m
0,0,0,0.01,0,0.1,0,0,0.2
0,0.2,0.001,,,,0,0.01,0.2
";

#[test]
fn points_are_enough_and_may_be_unseen() {
    let recording = read(POINTS).unwrap();
    assert_eq!(recording.tip_m, None);
    assert_eq!(
        recording.points.iter().map(|point| point.name.as_str()).collect::<Vec<_>>(),
        ["a", "b"]
    );
    let a = recording.point("a").unwrap();
    assert!(a.is_seen(0) && !a.is_seen(1) && recording.point("b").unwrap().is_seen(1));
    assert!(recording.extra.is_empty(), "{:?}", recording.extra);
    let folder = tempfile::tempdir().unwrap();
    for name in ["rec.csv", "rec.parquet"] {
        let path = folder.path().join(name);
        recording.write(&path).unwrap();
        let again = Recording::read(&path).unwrap();
        assert_eq!(
            (&again.points[1], again.point("a").unwrap().is_seen(1)),
            (&recording.points[1], false),
            "{name}"
        );
    }
}

#[test]
fn points_are_refused_by_column() {
    let cases = [
        (POINTS.replace("point_a_y_m", "point_a_y"), "column `point_a_y_m`"),
        (
            POINTS.replace("0.01,0.2", "0.01,far"),
            "line 3, column `point_b_z_m`: found `far`, expected a number",
        ),
        (
            POINTS.replace("point_b_z_m", "point_b_qw"),
            "expected the columns `point_b_z_m`, `point_b_qx`, `point_b_qy`, `point_b_qz`",
        ),
    ];
    for (text, expected) in cases {
        let error = read(&text).expect_err(expected);
        assert!(error.contains(expected), "{error}\n  does not say: {expected}");
    }
    let (recording, path) = (read(POINTS).unwrap(), Path::new("rec.csv"));
    assert_eq!(recording.check_points(path, &["a".to_owned(), "b".to_owned()]), Ok(()));
    let error =
        recording.check_points(path, &["a".to_owned(), "c".to_owned()]).unwrap_err().to_string();
    let words = "rec.csv, line 1, column `point_b_x_m`: found the point `b`, expected a point of \
                 the model's `tracking.points`: a, c";
    assert_eq!(error, words);
    let far = read(&POINTS.replace("0.01,0,0.1", "10,0,100")).unwrap();
    let error = far.check_reach(path, [0.0; 3], 0.22).unwrap_err().to_string();
    assert!(error.contains("line 2, column `point_a_x_m`: found 10"), "{error}");
}

#[test]
fn joined_recordings_keep_the_points_of_all() {
    let mut other = read(&POINTS.replace("point_a", "point_c")).unwrap();
    other.pattern = Some(vec!["bend".to_owned(); 2]);
    let all = Recording::joined(&[read(POINTS).unwrap(), other]).unwrap();
    let seen =
        |name: &str| (0..4).map(|row| all.point(name).unwrap().is_seen(row)).collect::<Vec<_>>();
    assert_eq!(
        [seen("a"), seen("b"), seen("c")].concat(),
        [true, false, false, false, true, true, true, true, false, false, true, false]
    );
    assert_eq!(all.pattern.unwrap(), ["", "", "bend", "bend"]);
}

const DRIVES: &str = "\
trial,time_s,drive_pan_rad,drive_lift_m,tip_x_m,tip_y_m,tip_z_m
0,0,0,0,0,0,0.2
0,0.2,0.5,0.01,0,0,0.2
";

#[test]
fn drives_are_converted_to_tendons_and_written_as_they_came() {
    let gains = std::collections::BTreeMap::from([
        ("lift".to_owned(), vec![(2, 1.0), (0, 0.5)]),
        ("pan".to_owned(), vec![(0, 0.03), (1, -0.03)]),
    ]);
    let path = Path::new("rec.csv");
    let mut recording = read(DRIVES).unwrap();
    assert_eq!((recording.tendons(), recording.len(), recording.drives.len()), (0, 2, 2));
    recording.convert_drives(path, &gains, 3).unwrap();
    assert_eq!(recording.commands.row(1), [0.5 * 0.03 + 0.5 * 0.01, -0.5 * 0.03, 0.01]);
    assert_eq!(recording.drive_displacements(1), [0.01, 0.5], "by name");
    let folder = tempfile::tempdir().unwrap();
    for name in ["rec.csv", "rec.parquet"] {
        let file = folder.path().join(name);
        recording.write(&file).unwrap();
        let mut again = Recording::read(&file).unwrap();
        again.convert_drives(&file, &gains, 3).unwrap();
        assert_eq!(again, recording, "{name}");
    }
    let joined = Recording::joined(&[recording.clone(), recording.clone()]).unwrap();
    assert_eq!(
        (joined.len(), joined.drives[1].displacement.as_slice()),
        (4, &[0.0, 0.5, 0.0, 0.5][..])
    );
    let other = read(GOOD).unwrap();
    assert!(
        Recording::joined(&[recording, other])
            .unwrap_err()
            .to_string()
            .contains("commands of drives")
    );

    let mut lacking = gains.clone();
    lacking.remove("pan");
    let error =
        |gains| read(DRIVES).unwrap().convert_drives(path, gains, 3).unwrap_err().to_string();
    let words = "rec.csv, line 1, column `drive_pan_rad`: found the drive `pan`, expected a drive \
                 of the model: lift";
    assert_eq!(error(&lacking), words);
    let mut more = gains;
    more.insert("tilt".to_owned(), vec![(0, 1.0)]);
    assert!(
        error(&more)
            .contains("found no commands of the drive `tilt`, expected a column `drive_tilt_rad`")
    );
    let cases = [
        (
            DRIVES.replace("drive_lift_m", "drive_pan_m"),
            "found the drive `pan` in radians and in metres",
        ),
        (
            DRIVES.replace("drive_lift_m", "tendon_1_m"),
            "found commands of drives and of tendons, expected one of the two",
        ),
        (
            DRIVES.replace("0.5,0.01", "half,0.01"),
            "line 3, column `drive_pan_rad`: found `half`, expected radians",
        ),
    ];
    for (text, expected) in cases {
        let error = read(&text).expect_err(expected);
        assert!(error.contains(expected), "{error}\n  does not say: {expected}");
    }
}

#[test]
fn poses_have_any_times_and_gravity_stays_in_a_trial() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rec.csv");
    let times = GOOD.replace("0,0.000", "0,1700000003.5").replace("0,0.200", "0,1700000003.5");
    fs::write(&path, &times).unwrap();
    let poses = Recording::read_poses(&path).unwrap();
    assert_eq!(poses.time_s, [1700000003.5, 1700000003.5, 0.0]);
    assert!(Recording::read(&path).unwrap_err().to_string().contains("line 2, column `time_s`"));
    fs::write(&path, times.replace("1,0.000", "1,later")).unwrap();
    assert!(
        Recording::read_poses(&path)
            .unwrap_err()
            .to_string()
            .contains("line 4, column `time_s`: found `later`")
    );
    let turned = |last: &str| {
        let mut lines = GOOD.lines();
        let header =
            format!("{},gravity_x_m_s2,gravity_y_m_s2,gravity_z_m_s2", lines.next().unwrap());
        let rows: Vec<String> = lines
            .zip(["0,-9.81,0", last, "0,0,9.81"])
            .map(|(line, gravity)| format!("{line},{gravity}"))
            .collect();
        read(&format!("{header}\n{}\n", rows.join("\n")))
    };
    assert_eq!(turned("0,-9.81,0").unwrap().gravity_m_s2.unwrap()[2], [0.0, 0.0, 9.81]);
    let error = turned("0,-9.8,0").unwrap_err();
    assert!(
        error.contains(
            "line 3, column `gravity_y_m_s2`: found `-9.8`, expected -9.81, as in the previous row"
        ),
        "{error}"
    );
}
