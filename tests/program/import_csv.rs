//! `import csv`: files as other people's loggers write them, by a map. The motion is a simulated
//! one, which the files are written from by hand.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use spinebench::data::Recording;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::{Command, Output};

const NOMINAL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/models/nominal.yaml");
/// Steps of the commands, and frames of the tracker in each.
const STEPS: usize = 150;
const FRAMES: usize = 20;
const FRAME_S: f64 = 0.01;
/// What is added to the tracker's stamps to be on the clock of the commands.
const OFFSET_S: f64 = -12.3456;
/// Length of each tendon at home, mm.
const HOME_MM: [f64; 4] = [310.5, 311.0, 309.25, 310.0];

struct Bench(tempfile::TempDir);

impl Bench {
    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn put(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    fn run(&self, arguments: &str) -> Output {
        let program = env!("CARGO_BIN_EXE_spinebench");
        let words = arguments.split(' ').map(|word| if word == "NOMINAL" { NOMINAL } else { word });
        Command::new(program).args(words).current_dir(self.0.path()).output().unwrap()
    }

    fn ok(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments}: {said}");
        said
    }

    /// Exit status 2, one line, and no output.
    fn refused(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments}: {said}");
        assert!(said.starts_with("error: ") && said.trim_end().lines().count() == 1, "{said}");
        assert!(!self.path("out.csv").exists(), "{arguments}");
        said
    }

    fn read(&self, name: &str) -> Recording {
        Recording::read(&self.path(name)).unwrap()
    }
}

/// Random displacements of two antagonistic pairs, metres, by a linear congruence.
fn commands() -> Vec<[f64; 4]> {
    let mut state = 12345_u64;
    let mut draw = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / (1_u64 << 31) as f64
    };
    let step = |k: usize| {
        let [a, b] = if k == 0 { [0.0; 2] } else { [0.02 * (draw() - 0.5), 0.02 * (draw() - 0.5)] };
        [a, b, -a, -b]
    };
    (0..STEPS).map(step).collect()
}

/// A folder with the simulated motion at the tracker's rate in `truth.csv`.
fn bench() -> (Bench, Recording) {
    let bench = Bench(tempfile::tempdir().unwrap());
    let mut text = "trial,time_s,tendon_1_m,tendon_2_m,tendon_3_m,tendon_4_m\n".to_owned();
    for (k, [a, b, c, d]) in commands().into_iter().enumerate() {
        for frame in 0..FRAMES {
            let time_s = FRAME_S * (k * FRAMES + frame) as f64;
            writeln!(text, "0,{time_s:.3},{a},{b},{c},{d}").unwrap();
        }
    }
    bench.put("fast.csv", &text);
    bench.ok("simulate --model NOMINAL --commands fast.csv --out truth.csv --quiet");
    let truth = bench.read("truth.csv");
    (bench, truth)
}

fn comma(number: f64, digits: usize) -> String {
    format!("{number:.digits$}").replace('.', ",")
}

/// A spreadsheet's log: byte-order mark, semicolons, decimal commas, comments, milliseconds since
/// somewhere, lengths of the tendons that are left in the robot, in mm.
fn write_log(bench: &Bench) {
    let mut text = "\u{feff}# rig 3\r\nRun;Stamp;L1;L2;L3;L4;\r\n".to_owned();
    for (k, pulls) in commands().into_iter().enumerate() {
        let stamp_ms = 1e3 * (90.0 + 0.2 * k as f64);
        let lengths: Vec<String> =
            pulls.iter().zip(HOME_MM).map(|(pull, home)| comma(home - 1e3 * pull, 7)).collect();
        write!(text, "7;{};{};\r\n", comma(stamp_ms, 1), lengths.join(";")).unwrap();
        if k == 70 {
            text += "# pause\r\n";
        }
    }
    bench.put("log.csv", &text);
}

/// The tracker's frame: y up, the base turned and away.
fn base() -> (Matrix3<f64>, UnitQuaternion<f64>, Vector3<f64>) {
    // Rows: our x, y and z in the tracker's axes.
    let ours = Matrix3::new(0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    (ours, UnitQuaternion::new(Vector3::new(0.3, -0.2, 0.1)), Vector3::new(1.1, 0.4, -0.3))
}

/// The tracker's export: tabs, microseconds on its own clock, mm, y up, quaternions x, y, z, w,
/// begun 3 s early.
fn write_tracking(bench: &Bench, truth: &Recording) {
    let (ours, turn, place) = base();
    let quaternion =
        |turn: &UnitQuaternion<f64>| format!("{}\t{}\t{}\t{}", turn.i, turn.j, turn.k, turn.w);
    let mut text = "t\tbx\tby\tbz\tbqx\tbqy\tbqz\tbqw\tx\ty\tz\tqx\tqy\tqz\tqw\n".to_owned();
    let still = std::iter::repeat_n(0, 300);
    for (k, row) in still.chain(0..truth.len()).enumerate() {
        let stamp_s = 90.0 - OFFSET_S + FRAME_S * (k as f64 - 300.0);
        let tip =
            turn * (ours.transpose() * Vector3::from(truth.tip_m.as_ref().unwrap()[row])) + place;
        let [w, x, y, z] = truth.tip_quaternion.as_ref().unwrap()[row];
        let own = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
        let own = ours.transpose() * own.to_rotation_matrix().into_inner() * ours;
        let own =
            turn * UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(own));
        let at = |p: Vector3<f64>| format!("{:.7}\t{:.7}\t{:.7}", 1e3 * p.x, 1e3 * p.y, 1e3 * p.z);
        let lost = (1000..1020).contains(&row);
        let tip = if lost { "\t\t".to_owned() } else { at(tip) };
        writeln!(
            text,
            "{:.0}\t{}\t{}\t{tip}\t{}",
            1e6 * stamp_s,
            at(place),
            quaternion(&turn),
            quaternion(&own)
        )
        .unwrap();
    }
    bench.put("track.txt", &text);
}

const MAP: &str = "
text: {delimiter: ';', decimal: ',', comment: '#'}
commands:
  time: {column: Stamp, unit: ms}
  trial: Run
  tendons: {columns: [L1, L2, L3, 6], unit: mm, measure: length}
tracking:
  text: {delimiter: \"\\t\"}
  time: {column: t, unit: us}
  unit: mm
  axes: x=+y,y=-x,z=+z
  quaternion: xyzw
  base: {position: [bx, by, bz], orientation: [bqx, bqy, bqz, bqw]}
  tip: {position: [x, y, z], orientation: [qx, qy, qz, qw]}
  clock: CLOCK
";

const IMPORT: &str = "import csv log.csv track.txt --map map.yaml --out out.csv";

#[test]
fn two_files_with_other_units_axes_rates_and_clocks_give_the_motion() {
    let (bench, truth) = bench();
    write_log(&bench);
    write_tracking(&bench, &truth);
    bench.put("map.yaml", &MAP.replace("CLOCK", &format!("{{offset_s: {OFFSET_S}}}")));
    let said = bench.ok(IMPORT);
    assert!(said.contains("1 of 150 rows were not tracked"), "{said}");
    let found = bench.read("out.csv");
    assert_eq!((found.len(), found.trial[0], found.time_s[5]), (STEPS, 7, 1.0));
    for (row, pulls) in commands().iter().enumerate() {
        let apart = found
            .commands
            .row(row)
            .iter()
            .zip(pulls)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(apart < 1e-9, "row {row}: {apart}");
        let frame = row * FRAMES;
        assert_eq!(found.is_valid(row), frame != 1000, "row {row}");
        if found.is_valid(row) {
            let apart = |a: &[f64], b: &[f64]| {
                a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
            };
            assert!(
                apart(&found.tip_m.as_ref().unwrap()[row], &truth.tip_m.as_ref().unwrap()[frame])
                    < 1e-8,
                "row {row}"
            );
            let [own, true_one] =
                [&found, &truth].map(|recording| recording.tip_quaternion.as_ref().unwrap());
            let dot: f64 = own[row].iter().zip(&true_one[frame]).map(|(a, b)| a * b).sum();
            assert!(dot.abs() > 1.0 - 1e-9, "row {row}");
        }
        let pose = found.base.as_ref().unwrap()[row];
        assert!(
            (pose.position_m[0] - 0.4).abs() < 1e-9 && (pose.position_m[1] + 1.1).abs() < 1e-9,
            "{pose:?}"
        );
    }
}

#[test]
fn an_unknown_offset_is_estimated_and_shown() {
    let (bench, truth) = bench();
    write_log(&bench);
    write_tracking(&bench, &truth);
    bench.put("map.yaml", &MAP.replace("CLOCK", "{estimate: {}}"));
    let said = bench.ok(IMPORT);
    let after = |mark: &str| -> f64 {
        said.split(mark).nth(1).unwrap().split(' ').next().unwrap().parse().unwrap()
    };
    let (offset_s, low_s) = (after("shifted by "), after("interval "));
    // The rod swings, where the estimate has one lag: within a fifth of a step.
    assert!((offset_s - OFFSET_S).abs() < 0.04, "{said}");
    let high_s = after(&format!("{low_s:.4} to "));
    assert!(low_s < OFFSET_S && OFFSET_S < high_s && high_s - low_s < 0.06, "{said}");
    // As far as scatter goes; the rest is half of the lag on either side.
    assert!(offset_s - low_s - 0.5 * after("with a lag of ") < 0.02, "{said}");
    assert!(said.contains("a recording does not distinguish the two"), "{said}");
    let found = bench.read("out.csv");
    let error_m = |row: usize| {
        let pair =
            [found.tip_m.as_ref().unwrap()[row], truth.tip_m.as_ref().unwrap()[row * FRAMES]];
        (Vector3::from(pair[0]) - Vector3::from(pair[1])).norm()
    };
    let rows: Vec<usize> = (0..STEPS).filter(|&row| found.is_valid(row)).collect();
    let rms_m =
        (rows.iter().map(|&row| error_m(row).powi(2)).sum::<f64>() / rows.len() as f64).sqrt();
    assert!(rms_m < 2e-3, "{rms_m}");
}

/// One file without a header, spaces between cells, encoder counts, tracking in the same rows with
/// times from 0 in each trial.
#[test]
fn rows_that_hold_both_are_taken_as_they_stand() {
    let bench = Bench(tempfile::tempdir().unwrap());
    let mut text = String::new();
    for trial in 0..2 {
        for k in 0..5 {
            let counts = 1000 + 40 * k * (trial + 1);
            let lost = if k == 3 { "0 0 0" } else { "12.5 0 2200" };
            writeln!(
                text,
                "  {trial} {:.2}   {counts} {}\t{lost}",
                0.05 * f64::from(k),
                2000 - counts
            )
            .unwrap();
        }
    }
    bench.put("log.csv", &text);
    bench.put(
        "map.yaml",
        "{text: {delimiter: ' ', header: false}, commands: {time: {column: 2}, trial: 1, tendons: \
         {columns: [3, 4], unit: count, scale: 1.0e-5, zero: trial_start}}, tracking: {unit: mm, \
         axes: 'x=-x,y=+y,z=+z', left_handed: true, origin: [0, 0, 2000], lost_value: 0, tip: \
         {position: [5, 6, 7]}}}",
    );
    bench.ok("import csv log.csv --map map.yaml --out out.csv");
    let found = bench.read("out.csv");
    assert_eq!(found.trial, [0, 0, 0, 0, 0, 1, 1, 1, 1, 1]);
    assert_eq!(
        (found.time_s[6], found.valid.as_ref().unwrap()[3], found.valid.as_ref().unwrap()[4]),
        (0.05, false, true)
    );
    let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
    assert!(close(found.commands.row(9)[0], 3.2e-3) && close(found.commands.row(9)[1], -3.2e-3));
    let tip = found.tip_m.as_ref().unwrap()[0];
    assert!(close(tip[0], -0.0125) && close(tip[2], 0.2), "{tip:?}");
    assert!(found.base.is_none() && found.extra.is_empty());
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of cases")]
fn faults_of_maps_and_files_are_told_with_their_place() {
    let bench = Bench(tempfile::tempdir().unwrap());
    let good = "{commands: {time: {column: t}, tendons: {columns: [a, b]}}, tracking: {time: \
                {column: t}, tip: {position: [x, y, z]}}}";
    let log = "t,a,b,x,y,z\n0,0,0,0,0,0.2\n0.1,0.001,-0.001,0,0,0.2\n0.2,0,0,0.001,0,0.2\n";
    let arguments = "import csv log.csv --map map.yaml --out out.csv";
    let of = |map: (&str, &str), file: (&str, &str)| {
        bench.put("map.yaml", &good.replace(map.0, map.1));
        bench.put("log.csv", &log.replace(file.0, file.1));
        bench.refused(arguments)
    };
    let maps = [
        ("column: t}, tendons", "colum: t}, tendons", "map.yaml:1:", "did you mean `column`"),
        ("columns: [a, b]", "columns: [a, 0]", "commands.tendons.columns[1]", "its number from 1"),
        ("columns: [a, b]", "columns: []", "commands.tendons.columns", "one column per tendon"),
        ("[a, b]", "[a, b], unit: furlong", "commands.tendons.unit", "`furlong`"),
        (
            "[a, b]",
            "[a, b], unit: count",
            "commands.tendons.scale",
            "metres of tendon per radian or per count",
        ),
        ("[a, b]", "[a, b], scale: [1, 2, 3]", "commands.tendons.scale", "one per tendon"),
        (
            "time: {column: t}, tip",
            "file: 2, time: {column: t}, tip",
            "tracking.file",
            "1 on the command line",
        ),
        ("time: {column: t}, tip", "axes: 'x=+y,y=+x,z=+z', tip", "tracking.axes", "left_handed"),
        (
            "time: {column: t}, tip",
            "clock: {offset_s: 1}, tip",
            "tracking.clock",
            "`time` in addition",
        ),
        (
            "tip: {",
            "clock: {estimate: {from_s: 1, to_s: 1}}, tip: {",
            "tracking.clock.estimate.to_s",
            "above `from_s`",
        ),
        (
            "tip: {",
            "clock: {estimate: {dead_time_s: -1}}, tip: {",
            "tracking.clock.estimate.dead_time_s",
            "0 or more",
        ),
        (
            "tip: {",
            "clock: {estimate: {to_s: .nan}}, tip: {",
            "tracking.clock.estimate.to_s",
            "a finite number",
        ),
        ("time: {column: t}, tip", "topic: /tip, tip", "tracking.topic", "text files have none"),
        (
            "position: [x, y, z]",
            "orientation: [x, y, z, a]",
            "tracking.tip.position",
            "the columns of x, y and z",
        ),
        (
            "{commands",
            "{text: {decimal: ','}, commands",
            "text.decimal",
            "another character than the delimiter",
        ),
    ];
    for (from, to, key, expected) in maps {
        let said = of((from, to), ("", ""));
        assert!(
            said.contains(key) && said.contains(expected) && said.contains("map.yaml"),
            "{to}: {said}"
        );
    }
    let files = [
        (
            "t,a,b",
            "t,A,b",
            "log.csv, line 1: found only `t`, `A`, `b`, `x`, `y`, `z`, expected the column `a` \
             that `commands.tendons.columns`",
        ),
        ("t,a,b,x,y,z", "t;a;b;x;y;z", "log.csv, line 2: found 6 cells, expected 1 as in line 1"),
        ("0.1,0.001", "0.1,one", "log.csv, line 3, column `a`: found `one`, expected a number"),
        ("0.1,0.001", "0.1,", "log.csv, line 3, column `a`: found nothing, expected a number"),
        (
            "0.2,0,0,0.001",
            "0.1,0,0,0.001",
            "log.csv, line 4, column `t`: found `0.1`, expected a later time",
        ),
        ("0.2,0,0,0.001", "0.2,0,0,0.001m", "log.csv, line 4, column `x`: found `0.001m`"),
        (",0,0,0.2\n0.2", ",0,0\n0.2", "log.csv, line 3: found 5 cells, expected 6"),
    ];
    for (from, to, expected) in files {
        let said = of(("", ""), (from, to));
        assert!(said.contains(expected), "{said}");
    }
    let said = of(("tip: {", "clock: {estimate: {}}, tip: {"), ("", ""));
    assert!(said.contains("3 tracked frames and 3 commands"), "{said}");
    assert!(bench.refused("import csv none.csv --map map.yaml --out out.csv").contains("none.csv"));
    assert!(
        bench.refused("import csv log.csv --map none.yaml --out out.csv").contains("none.yaml")
    );
    bench.put("map.yaml", good);
    bench.put("log.csv", log);
    bench.ok(arguments);
}
