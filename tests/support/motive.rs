//! Exports in the dialects of Motive's versions, written from a motion that is known, and the
//! program run on them.

use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use spinebench::data::Recording;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

pub(crate) const RATE_HZ: f64 = 120.0;
pub(crate) const FRAMES: usize = 361;
pub(crate) const LENGTHS: &str = "trial,time_s,tendon_1_m,tendon_2_m";
pub(crate) const GOOD: &str = "motive export.csv --commands log.csv --out out.csv";

/// How an export is written.
#[derive(Clone, Copy)]
pub(crate) struct Dialect {
    pub(crate) version: &'static str,
    /// Rows carry `Type`, `Name`, … in their second cell.
    pub(crate) labelled: bool,
    pub(crate) parents: bool,
    pub(crate) timecode: bool,
    pub(crate) unit: (&'static str, f64, usize),
    /// Markers before, between and after the bodies.
    pub(crate) markers: bool,
    /// Columns and bodies the other way round.
    pub(crate) backwards: bool,
    pub(crate) euler: bool,
    pub(crate) mark: bool,
    pub(crate) end: &'static str,
}

pub(crate) const PLAIN: Dialect = Dialect {
    version: "1.23",
    labelled: false,
    parents: false,
    timecode: false,
    unit: ("Meters", 1.0, 6),
    markers: false,
    backwards: false,
    euler: false,
    mark: false,
    end: "\r\n",
};

pub(crate) fn dialects() -> Vec<Dialect> {
    let millimetres = ("Millimeters", 1e3, 3);
    vec![
        PLAIN,
        Dialect { version: "1.20", markers: true, ..PLAIN },
        Dialect { version: "1.21", unit: millimetres, mark: true, ..PLAIN },
        Dialect { version: "1.22", labelled: true, backwards: true, end: "\n", ..PLAIN },
        Dialect {
            labelled: true,
            parents: true,
            markers: true,
            backwards: true,
            unit: millimetres,
            ..PLAIN
        },
        Dialect {
            version: "1.24",
            labelled: true,
            timecode: true,
            unit: ("Centimeters", 1e2, 4),
            ..PLAIN
        },
        Dialect {
            version: "1.25",
            labelled: true,
            parents: true,
            timecode: true,
            markers: true,
            mark: true,
            ..PLAIN
        },
        Dialect { euler: true, ..PLAIN },
        Dialect { unit: ("Inches", 1.0 / 0.0254, 9), ..PLAIN },
    ]
}

/// The tip from the base in the project's frame: place and turn.
pub(crate) fn tip(time_s: f64) -> (Vector3<f64>, UnitQuaternion<f64>) {
    let bend = 0.5 * (1.3 * time_s).sin();
    let place_m = Vector3::new(0.22 * bend, 0.05 * (0.7 * time_s).cos(), 0.22 - 0.05 * bend * bend);
    (place_m, UnitQuaternion::new(Vector3::new(0.1 * bend, bend, 0.2)))
}

/// The base in Motive's frame.
pub(crate) fn base() -> (Vector3<f64>, UnitQuaternion<f64>) {
    (Vector3::new(0.4, 1.1, -0.3), UnitQuaternion::new(Vector3::new(0.05, 0.6, -0.02)))
}

/// From the project's axes to Motive's by the default: x is its y, y its −x.
pub(crate) fn to_motive(v: Vector3<f64>) -> Vector3<f64> {
    Vector3::new(-v.y, v.x, v.z)
}

pub(crate) fn turn_to_motive(q: UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::new(to_motive(q.scaled_axis()))
}

/// A column: kind, name, ID, parent, quantity, part, and its cell in each frame.
pub(crate) type Column = ([String; 6], Vec<String>);

pub(crate) fn column(words: [&str; 6], cells: impl Iterator<Item = String>) -> Column {
    (words.map(str::to_owned), cells.collect())
}

/// The columns of a body, empty in the frames `lost`.
pub(crate) fn body(
    dialect: &Dialect,
    (name, id): (&str, &str),
    lost: &[usize],
    pose: impl Fn(f64) -> (Vector3<f64>, UnitQuaternion<f64>),
) -> Vec<Column> {
    let (_, scale, digits) = dialect.unit;
    let mut parts: Vec<(&str, &str, usize)> =
        vec![("Rotation", "X", 0), ("Rotation", "Y", 1), ("Rotation", "Z", 2)];
    if !dialect.euler {
        parts.push(("Rotation", "W", 3));
    }
    parts.extend([
        ("Position", "X", 4),
        ("Position", "Y", 5),
        ("Position", "Z", 6),
        ("Mean Marker Error", "", 7),
    ]);
    let cell = |index: usize, frame: usize| {
        let (place_m, turn) = pose(frame as f64 / RATE_HZ);
        if lost.contains(&frame) {
            return String::new();
        }
        match index {
            0..3 if dialect.euler => format!("{:.8}", xyz_deg(&turn)[index]),
            0..4 => format!("{:.8}", turn.coords[index]),
            4..7 => format!("{:.digits$}", scale * place_m[index - 4]),
            _ => "0.000213".to_owned(),
        }
    };
    let column = |(quantity, part, index): (&str, &str, usize)| {
        let words = ["Rigid Body", name, id, "", quantity, part];
        self::column(words, (0..FRAMES).map(move |frame| cell(index, frame)))
    };
    parts.into_iter().map(column).collect()
}

/// Degrees about x, the new y and the newest z.
pub(crate) fn xyz_deg(turn: &UnitQuaternion<f64>) -> [f64; 3] {
    let m = turn.to_rotation_matrix();
    let angles = [(-m[(1, 2)]).atan2(m[(2, 2)]), m[(0, 2)].asin(), (-m[(0, 1)]).atan2(m[(0, 0)])];
    let [x, y, z] = angles;
    let again = Rotation3::from_axis_angle(&Vector3::x_axis(), x)
        * Rotation3::from_axis_angle(&Vector3::y_axis(), y)
        * Rotation3::from_axis_angle(&Vector3::z_axis(), z);
    assert!((again.matrix() - m.matrix()).norm() < 1e-9);
    angles.map(f64::to_degrees)
}

/// A marker: full of cells that are no business of ours.
pub(crate) fn marker(kind: &str, name: &str) -> Vec<Column> {
    let cells = ["X", "Y", "Z"].map(|part| {
        let words = [kind, name, "77", "", "Position", part];
        column(
            words,
            (0..FRAMES).map(|frame| if frame % 3 == 0 { String::new() } else { "12.5".to_owned() }),
        )
    });
    cells
        .into_iter()
        .chain([column(
            [kind, name, "77", "", "Marker Quality", ""],
            vec!["?".into(); FRAMES].into_iter(),
        )])
        .collect()
}

/// An export; the tip is not seen in the frames `lost`.
pub(crate) fn export(dialect: &Dialect, lost: &[usize]) -> String {
    let place = |time_s: f64| {
        let ((base_m, base_turn), (tip_m, tip_turn)) = (base(), tip(time_s));
        (base_m + base_turn * to_motive(tip_m), base_turn * turn_to_motive(tip_turn))
    };
    let bodies = [
        body(dialect, ("base", "1"), &[], |_| base()),
        body(dialect, ("\"tip, upper\"", "2"), lost, place),
    ];
    let mut columns: Vec<Column> = Vec::new();
    for (index, body) in bodies.into_iter().enumerate() {
        if dialect.markers {
            columns.extend(marker("Rigid Body Marker", &format!("base:Marker{index}")));
            columns.extend(marker("Marker", "tip"));
        }
        columns.extend(body);
    }
    if dialect.markers {
        columns.extend(marker("Marker", "Unlabeled 1189"));
    }
    if dialect.backwards {
        columns.reverse();
    }
    written(dialect, &columns)
}

pub(crate) fn written(dialect: &Dialect, columns: &[Column]) -> String {
    let (unit, ..) = dialect.unit;
    let rotation = if dialect.euler { "XYZ" } else { "Quaternion" };
    let mut lines = vec![
        format!(
            "Format Version,{},Take Name,\"Take, 2018-10-04\",Take Notes,,Capture Frame \
             Rate,120.000000,Export Frame Rate,120.000000,Capture Start Time,2018-10-05 \
             12.05.03.445 PM,Total Frames in Take,900,Total Exported Frames,{FRAMES},Rotation \
             Type,{rotation},Length Units,{unit},Coordinate Space,Global",
            dialect.version
        ),
        String::new(),
    ];
    let leading = if dialect.timecode {
        vec!["Frame", "Time (Seconds)", "TimeCode"]
    } else {
        vec!["Frame", "Time (Seconds)"]
    };
    for (row, label) in ["Type", "Name", "ID", "Parent", "", ""].into_iter().enumerate() {
        if label == "Parent" && !dialect.parents {
            continue;
        }
        let mut cells: Vec<String> = vec![String::new(); leading.len()];
        if row == 5 {
            cells = leading.iter().map(|&cell| cell.to_owned()).collect();
        } else if dialect.labelled {
            cells[1] = label.to_owned();
        }
        cells.extend(columns.iter().map(|(words, _)| words[row].clone()));
        lines.push(cells.join(","));
    }
    for frame in 0..FRAMES {
        let mut cells = vec![frame.to_string(), format!("{:.6}", frame as f64 / RATE_HZ)];
        if dialect.timecode {
            cells.push("15:26:46:12.02".to_owned());
        }
        cells.extend(columns.iter().map(|(_, cells)| cells[frame].clone()));
        lines.push(cells.join(","));
    }
    let mark = if dialect.mark { "\u{feff}" } else { "" };
    format!("{mark}{}{}", lines.join(dialect.end), dialect.end)
}

/// A folder with files in it, and the program run there.
pub(crate) struct Bench(tempfile::TempDir);

impl Bench {
    /// With a log of two trials that say when they were in the export.
    pub(crate) fn new(export: &str) -> Bench {
        let bench = Bench(tempfile::tempdir().unwrap());
        bench.put("export.csv", export);
        bench.put("log.csv", &log());
        bench
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn put(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    pub(crate) fn run(&self, arguments: &[&str]) -> Output {
        let program = Path::new(env!("CARGO_BIN_EXE_spinebench"));
        Command::new(program)
            .arg("import")
            .args(arguments)
            .current_dir(self.0.path())
            .output()
            .unwrap()
    }

    pub(crate) fn imported(&self, more: &[&str]) -> (Recording, String) {
        let arguments: Vec<&str> = GOOD.split(' ').chain(more.iter().copied()).collect();
        let output = self.run(&arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{more:?}: {said}");
        (Recording::read(&self.path("out.csv")).unwrap(), said)
    }

    /// Runs what must be refused with exit status 2, leaving nothing.
    pub(crate) fn refused(&self, more: &[&str]) -> String {
        std::fs::remove_file(self.path("out.csv")).unwrap_or_default();
        let arguments: Vec<&str> = GOOD.split(' ').chain(more.iter().copied()).collect();
        let output = self.run(&arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{more:?}: {said}");
        assert!(said.starts_with("error: "), "{said}");
        assert_eq!(std::fs::read_dir(self.0.path()).unwrap().count(), 2, "{more:?} left something");
        said
    }
}

/// Export times of the two trials' rows.
pub(crate) const AT_S: [f64; 6] = [0.25, 0.4531, 0.7, 1.0, 1.2, 1.7654];
pub(crate) const START_S: [f64; 2] = [0.25, 1.0];

pub(crate) fn log() -> String {
    let mut text = format!("{LENGTHS},export_time_s,note\n");
    for (row, at_s) in AT_S.into_iter().enumerate() {
        let trial = row / 3;
        text += &format!("{trial},{},0.00{row},0,{at_s},n{row}\n", at_s - START_S[trial]);
    }
    text
}

pub(crate) fn plain_log() -> String {
    log().lines().map(|line| line.rsplitn(3, ',').last().unwrap().to_owned() + "\n").collect()
}

pub(crate) fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// The largest difference between what was measured in two recordings.
pub(crate) fn difference(a: &Recording, b: &Recording) -> f64 {
    assert_eq!((&a.commands, &a.valid, &a.time_s), (&b.commands, &b.valid, &b.time_s));
    let numbers = |recording: &Recording| {
        let mut all: Vec<f64> = recording.tip_m.iter().flatten().flatten().copied().collect();
        all.extend(recording.tip_quaternion.iter().flatten().flatten());
        all.extend(
            recording
                .base
                .iter()
                .flatten()
                .flat_map(|pose| pose.position_m.into_iter().chain(pose.quaternion)),
        );
        all.iter().map(|number| if number.is_nan() { 9.0 } else { *number }).collect::<Vec<f64>>()
    };
    assert_eq!(numbers(a).len(), 14 * a.len());
    apart(&numbers(a), &numbers(b))
}
