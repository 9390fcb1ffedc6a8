//! `import csv` of layouts that people's loggers have: several bodies in one table, frames in place
//! of times, times in several columns or of day, several tables in a file. One motion, written in
//! many ways, gives the same rows.

use spinebench::data::Recording;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::{Command, Output};

struct Bench(tempfile::TempDir);

impl Bench {
    fn new() -> Bench {
        let bench = Bench(tempfile::tempdir().unwrap());
        let mut text = "t,p1,p2\n".to_owned();
        for step in 0..5 {
            let time_s = 0.2 * f64::from(step);
            writeln!(text, "{time_s:.1},{:.4},0", 2.0 * (2.0 * time_s).sin()).unwrap();
        }
        bench.put("commands.csv", &text);
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn put(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    fn run(&self, arguments: &str) -> Output {
        let _ = std::fs::remove_file(self.path("out.csv"));
        Command::new(env!("CARGO_BIN_EXE_spinebench"))
            .args(arguments.split(' '))
            .current_dir(self.0.path())
            .output()
            .unwrap()
    }

    /// What the import of `log.csv` with this map of the tracking says and gives.
    fn import(&self, tracking: &str) -> (String, Recording) {
        let said = self.status(tracking, 0);
        (said, Recording::read(&self.path("out.csv")).unwrap())
    }

    fn refused(&self, tracking: &str) -> String {
        let said = self.status(tracking, 2);
        assert!(said.starts_with("error: ") && said.trim_end().lines().count() == 1, "{said}");
        assert!(!self.path("out.csv").exists());
        said
    }

    fn status(&self, tracking: &str, status: i32) -> String {
        let map = format!("commands:\n  {COMMANDS}\ntracking: {{unit: mm, {tracking}}}\n");
        self.put("map.yaml", &map);
        let output = self.run("import csv commands.csv log.csv --map map.yaml --out out.csv");
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(status), "{map}\n{said}");
        said
    }

    /// The motion comes out of the log, with nothing to say.
    fn gives_the_motion(&self, log: &str, tracking: &str) {
        self.put("log.csv", log);
        let (said, found) = self.import(tracking);
        assert!(!said.contains("note"), "{tracking}: {said}");
        assert_eq!(found.time_s, [0.0, 0.2, 0.4, 0.6, 0.8]);
        for (row, tip) in found.tip_m.unwrap().into_iter().enumerate() {
            let expected = tip_mm(20 * row).map(|x| 1e-3 * x);
            let apart = tip.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-9, "{tracking}, row {row}: {tip:?} for {expected:?}");
        }
    }
}

const COMMANDS: &str = "{time: {column: t}, tendons: {columns: [p1, p2], unit: mm}}";
/// Frames of the tracker, at 100 Hz.
const FRAMES: usize = 100;
const TIP: &str = "tip: {position: [x, y, z]}, origin: [0, 0, 0]";

/// The tip from the base in a frame, mm, with the digits of a log.
fn tip_mm(frame: usize) -> [f64; 3] {
    let x = (1e4 * (0.02 * frame as f64).sin()).round() / 1e3;
    [x, 0.0, 220.0 - x.abs() / 5.0]
}

/// A table with what `before` says of a frame in front of the tip.
fn log(header: &str, delimiter: &str, before: impl Fn(usize) -> String) -> String {
    let mut text = header.to_owned();
    for frame in 0..FRAMES {
        let [x, y, z] = tip_mm(frame);
        let cells = [before(frame), x.to_string(), y.to_string(), z.to_string()];
        let cells: Vec<String> = cells.into_iter().filter(|cell| !cell.is_empty()).collect();
        writeln!(text, "{}", cells.join(delimiter)).unwrap();
    }
    text
}

/// A table with a row a body and an offset of the rows of the tip, seconds.
fn long_log(late_s: f64) -> String {
    let mut text = "tool,time,x,y,z\n".to_owned();
    for frame in 0..FRAMES {
        let ([x, y, z], time_s) = (tip_mm(frame), 0.01 * frame as f64);
        writeln!(text, "base,{time_s:.3},100,20,-50").unwrap();
        writeln!(text, "tip,{:.4},{},{},{}", time_s + late_s, x + 100.0, y + 20.0, z - 50.0)
            .unwrap();
    }
    text
}

#[test]
fn the_rows_of_a_body_are_chosen_by_a_column() {
    let bench = Bench::new();
    let time = "time: {column: time}";
    let body = |name: &str| format!("{{where: {{tool: {name}}}, position: [x, y, z]}}");
    let both = format!("{time}, tip: {}, base: {}", body("tip"), body("base"));
    bench.gives_the_motion(&long_log(0.0), &both);
    // Numbers as names, however they are written.
    let numbered = long_log(0.0).replace("base,", "0,").replace("tip,", "1.0,");
    bench.gives_the_motion(
        &numbered,
        &both.replace("tool: tip", "tool: 1").replace("base}, ", "0}, "),
    );
    bench.put("log.csv", &long_log(0.0));
    let said = bench.refused(&format!("{time}, tip: {}, origin: [0, 0, 0]", body("hand")));
    assert!(
        said.contains(
            "log.csv, column `tool`: found only `base`, `tip`, expected rows with `hand`"
        ),
        "{said}"
    );
    // Frames are those of the file, also where the tip was seen later than the base.
    let mut framed = "tool,frame,x,y,z\n".to_owned();
    for frame in 0..FRAMES + 3 {
        writeln!(framed, "base,{},100,20,-50", frame + 1).unwrap();
        if frame >= 3 {
            let [x, y, z] = tip_mm(frame - 3);
            writeln!(framed, "tip,{},{},{},{}", frame + 1, x + 100.0, y + 20.0, z - 50.0).unwrap();
        }
    }
    let time = "time: {column: frame, rate_hz: 100}, clock: {offset_s: -0.03}";
    let both = format!("{time}, tip: {}, base: {}", body("tip"), body("base"));
    bench.gives_the_motion(&framed, &both);
    bench.put("log.csv", &long_log(0.0));
    let said = bench.refused(&format!("tip: {}, origin: [0, 0, 0]", body("tip")));
    assert!(said.contains("tracking.time"), "{said}");
}

#[test]
fn rows_of_several_bodies_are_not_taken_for_one() {
    let bench = Bench::new();
    let tracking = format!("time: {{column: time}}, {TIP}");
    bench.put("log.csv", &long_log(0.0));
    let said = bench.refused(&tracking);
    assert!(
        said.contains(
            "log.csv, line 3, column `time`: found another pose than in line 2 at the same time"
        ),
        "{said}"
    );
    assert!(said.contains("`tracking.tip.where` of the map selects"), "{said}");
    // At times of their own nothing contradicts itself, but the tip jumps.
    bench.put("log.csv", &long_log(0.002));
    let (said, _) = bench.import(&tracking);
    assert!(
        said.contains("the tip repeatedly jumps by") && said.contains("`tracking.tip.where`"),
        "{said}"
    );
}

#[test]
fn repeated_rows_count_once_and_a_later_command_on_request() {
    let bench = Bench::new();
    let tracking = format!("time: {{column: t}}, {TIP}");
    let stamped = |frame: usize| format!("{:.2}", 0.01 * (frame / 2 * 2) as f64);
    let log_text = log("t,x,y,z\n", ",", stamped);
    // Every second row is the row before once more.
    let lines: Vec<&str> = log_text.lines().collect();
    let twice: Vec<&str> = (0..FRAMES).map(|frame| lines[1 + frame / 2 * 2]).collect();
    bench.put("log.csv", &format!("{}\n{}\n", lines[0], twice.join("\n")));
    let (said, _) = bench.import(&tracking);
    assert!(said.contains("note: 50 tracked rows repeat the time and the pose"), "{said}");
    bench.put("log.csv", &log("t,x,y,z\n", ",", |frame| format!("{:.2}", 0.01 * frame as f64)));
    let commands = std::fs::read_to_string(bench.path("commands.csv")).unwrap();
    bench.put("commands.csv", &commands.replace("\n0.2,", "\n0.2,9,0\n0.2,"));
    let said = bench.refused(&tracking);
    assert!(said.contains("commands.csv, line 4, column `t`"), "{said}");
    assert!(said.contains("a later time than in line 3") && said.contains("last"), "{said}");
    let output =
        bench.run("import csv commands.csv log.csv --map map.yaml --repeated last --out out.csv");
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("note: 1 rows of commands have the same time as the next row"), "{said}");
    let found = Recording::read(&bench.path("out.csv")).unwrap();
    assert_eq!((found.len(), found.commands.row(1)[0] < 0.001), (5, true));
}

#[test]
fn times_are_frames_sums_or_times_of_day() {
    let bench = Bench::new();
    let starts = "clock: {first_row_after_s: 0}";
    // Since 09:59:59.600, ms.
    let ms = |frame: usize| 35_999_600 + 10 * frame;
    let csv = |columns: &str, before: &dyn Fn(usize) -> String| {
        log(&format!("{columns},x,y,z\n"), ",", before)
    };
    let frames = csv("frame", &|frame| (frame + 1).to_string());
    bench.gives_the_motion(&frames, &format!("time: {{column: frame, rate_hz: 100}}, {TIP}"));
    let plain = log("x,y,z\n", ",", |_| String::new());
    bench.gives_the_motion(&plain, &format!("time: {{rate_hz: 100}}, {TIP}"));
    let stamps = csv("secs,nsecs", &|frame| {
        let ns = 950_000_000 + 10_000_000 * frame as u64;
        format!("{},{}", 1_700_000_000 + ns / 1_000_000_000, ns % 1_000_000_000)
    });
    let sum = "time: {sum: [{column: secs, unit: s}, {column: nsecs, unit: ns}]}";
    bench.gives_the_motion(&stamps, &format!("{sum}, {starts}, {TIP}"));
    let parts = csv("hour,min,sec,ms", &|frame| {
        let ms = ms(frame);
        format!("{},{},{},{}", ms / 3_600_000, ms / 60_000 % 60, ms / 1000 % 60, ms % 1000)
    });
    let sum = "time: {sum: [{column: hour, unit: h}, {column: min, unit: min}, {column: sec, unit: \
               s}, {column: ms, unit: ms}]}";
    bench.gives_the_motion(&parts, &format!("{sum}, {starts}, {TIP}"));
    let of_day = |ms: usize| {
        format!(
            "{:02}:{:02}:{:02}.{:03}",
            ms / 3_600_000 % 24,
            ms / 60_000 % 60,
            ms / 1000 % 60,
            ms % 1000
        )
    };
    let day = format!("time: {{column: time, unit: time_of_day}}, {starts}, {TIP}");
    bench.gives_the_motion(&csv("time", &|frame| of_day(ms(frame))), &day);
    // Over midnight.
    bench.gives_the_motion(&csv("time", &|frame| of_day(86_399_600 + 10 * frame)), &day);
    let header = log("FREQUENCY\t100\nMARKER_NAMES\ttip\n", "\t", |_| String::new());
    let tsv = "text: {delimiter: \"\\t\", skip_lines: 2, header: false}";
    let tip = "tip: {position: [1, 2, 3]}, origin: [0, 0, 0]";
    bench.gives_the_motion(&header, &format!("{tsv}, time: {{rate_hz: FREQUENCY}}, {tip}"));
    let comment = log("# recorded at 100 Hz\nx,y,z\n", ",", |_| String::new());
    bench.gives_the_motion(
        &comment,
        &format!("text: {{comment: '#'}}, time: {{rate_hz: recorded at}}, {TIP}"),
    );
    // Missing frames leave a gap, and a first frame is where it is.
    let some = |frame: usize| !(30..=45).contains(&frame);
    let lines: Vec<String> = frames.lines().map(str::to_owned).collect();
    let kept = (0..FRAMES).filter(|frame| some(*frame)).map(|frame| lines[frame + 1].clone());
    bench.put("log.csv", &format!("{}\n{}\n", lines[0], kept.collect::<Vec<_>>().join("\n")));
    let (said, found) =
        bench.import(&format!("time: {{column: frame, rate_hz: 100, first_frame: 1}}, {TIP}"));
    assert!(said.contains("1 of 5 rows were not tracked"), "{said}");
    assert!(!found.is_valid(2) && found.is_valid(3));
}

#[test]
fn faults_of_times_name_what_helps() {
    let bench = Bench::new();
    bench.put("log.csv", &log("time,x,y,z\n", ",", |frame| format!("10:00:{:02}.0", frame % 60)));
    let said = bench.refused(&format!("time: {{column: time, unit: iso8601}}, {TIP}"));
    assert!(said.contains("`unit: time_of_day` for times without a date"), "{said}");
    let said = bench.refused(&format!("time: {{column: time}}, {TIP}"));
    assert!(said.contains("`unit: time_of_day` for times of day"), "{said}");
    bench.put("log.csv", &log("time,x,y,z\n", ",", |frame| format!("{}", 1000 + frame)));
    let said = bench.refused(&format!("time: {{column: time}}, {TIP}"));
    assert!(said.contains("`{first_row_after_s: 0}` if both begin together"), "{said}");
    for (time, expected) in [
        ("{rate_hz: 0}", "above 0"),
        ("{rate_hz: 100, unit: ms}", "which numbers the frames"),
        ("{column: time, first_frame: 3}", "`rate_hz` in addition"),
        ("{column: time, sum: [{column: x, unit: s}]}", "one of the two"),
        ("{unit: s}", "the column of times, or `sum`, or `rate_hz`"),
        ("{rate_hz: SPEED}", "no word `SPEED`"),
        ("{column: x, rate_hz: 100}", "a whole number"),
    ] {
        let said = bench.refused(&format!("time: {time}, {TIP}"));
        assert!(said.contains(expected), "{time}: {said}");
    }
}

#[test]
fn a_table_of_several_in_a_file_is_read_to_its_end() {
    let bench = Bench::new();
    let mut text =
        "Devices\n1000\n,,force\nFrame,Sub Frame,F\n,,N\n1,0,3\n\nObjects\n100\n,,base,,,\
                    tip,,\nFrame,Sub Frame,TX,TY,TZ,TX,TY,TZ\n,,mm,mm,mm,mm,mm,mm\n"
            .to_owned();
    for frame in 0..FRAMES {
        let [x, y, z] = tip_mm(frame);
        writeln!(text, "{},0,10,20,5,{},{},{}", frame + 1, x + 10.0, y + 20.0, z + 5.0).unwrap();
    }
    text += "\nTrajectories\n100\nFrame,X\n1,2\n";
    let block = "text: {block: Objects, skip_lines: 1, header_lines: 2, units_line: true}, time: \
                 {column: Frame, rate_hz: Objects}";
    let bodies = "base: {position: [base TX, base TY, base TZ]}, tip: {position: [tip TX, tip TY, \
                  tip TZ]}";
    bench.gives_the_motion(&text, &format!("{block}, {bodies}"));
    let said =
        bench.refused(&format!("{}, {bodies}", block.replace("block: Objects", "block: Bodies")));
    assert!(said.contains("tables that begin with `Devices`, `Objects`, `Trajectories`"), "{said}");
    bench.put("log.csv", &text.replace(",,mm,mm,mm,mm,mm,mm", ",,mm,mm,mm,m,mm,mm"));
    let said = bench.refused(&format!("{block}, {bodies}"));
    assert!(
        said.contains("column `tip TX`: found the unit `m`, expected `mm` as `tracking.unit`"),
        "{said}"
    );
}

#[test]
fn poses_at_rest_need_no_times() {
    let bench = Bench::new();
    bench.put("poses.csv", "p1,p2,x,y,z\n0,0,0,0,220\n1,-1,5,0,219.8\n2,-2,10,0,219.4\n");
    let map = "commands: {tendons: {columns: [p1, p2], unit: mm}}\ntracking: {unit: mm, tip: \
               {position: [x, y, z]}, origin: [0, 0, 0]}\n";
    bench.put("map.yaml", map);
    let output = bench.run("import csv poses.csv --map map.yaml --out out.csv");
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("the 3 rows are marked as poses at rest"), "{said}");
    let found = Recording::read(&bench.path("out.csv")).unwrap();
    assert_eq!(found.tip_m.unwrap()[2], [0.01, 0.0, 0.2194]);
}

/// Rows of the tip are chosen from a log that holds commands as well.
#[test]
fn commands_and_poses_of_one_log_are_told_by_a_column() {
    let bench = Bench::new();
    let mut text = "time,what,a,b,c\n".to_owned();
    for frame in 0..FRAMES {
        let ([x, y, z], time_s) = (tip_mm(frame), 0.01 * frame as f64);
        if frame % 20 == 0 {
            writeln!(text, "{time_s},command,{},0,", frame).unwrap();
        }
        writeln!(text, "{time_s},pose,{x},{y},{z}").unwrap();
    }
    bench.put("log.csv", &text);
    let map = "commands: {where: {what: command}, time: {column: time}, tendons: {columns: [a, b], \
               unit: mm}}\ntracking: {unit: mm, time: {column: time}, origin: [0, 0, 0], tip: \
               {where: {what: pose}, position: [a, b, c]}}\n";
    bench.put("map.yaml", map);
    let output = bench.run("import csv log.csv --map map.yaml --out out.csv");
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}");
    let found = Recording::read(&bench.path("out.csv")).unwrap();
    assert_eq!((found.len(), found.commands.row(4)[0]), (5, 0.08));
}
