//! Recordings as MCAP files that viewers such as Foxglove open: poses, commands, and lines in
//! space.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use super::{BagWriter, robot};
use crate::base::Point3;
use crate::data::Recording;
use crate::data::findings::ResidualRow;
use crate::data::recording::Extra;
use crate::data::scene::Scene;

/// Frame of all positions.
pub(super) const FRAME: &str = "base";
/// Time between trials, seconds.
const PAUSE_S: f64 = 1.0;
/// Kind of line of `foxglove.SceneUpdate` that goes through all points.
const LINE_STRIP: u8 = 0;
/// Thickness of lines of residuals, metres.
const RESIDUAL_LINE_M: f64 = 1e-3;
/// Colours of residuals.
const BEFORE_COLOUR: [f64; 3] = [0.9, 0.3, 0.2];
const AFTER_COLOUR: [f64; 3] = [0.2, 0.7, 0.3];

/// What an MCAP file shows.
#[derive(Clone, Copy, Debug)]
pub struct Shown<'a> {
    /// The recording.
    pub recording: &'a Recording,
    /// Every row is a pose at rest: row k is shown at k seconds.
    pub at_rest: bool,
    /// The robot of a model in each row of the recording.
    pub robot: Option<&'a Scene>,
    /// Residuals of a discovery on this recording.
    pub residuals: &'a [ResidualRow],
}

/// The bytes of an MCAP file: `/tip`, `/base` and `/points/NAME` (`foxglove.PoseInFrame`),
/// `/commands` and `/row` (numbers), `/robot` (`foxglove.SceneUpdate`: backbone, disks, tendons) and
/// `/tf` (`foxglove.FrameTransforms`: a frame for each cross-section) where there is a robot, `/residuals` and `/residual_lines` where there are any. Trials follow each other with a
/// second between them.
pub fn to_mcap(shown: &Shown) -> Vec<u8> {
    let recording = shown.recording;
    let times_ns = times_ns(shown);
    let mut writer = BagWriter::new();
    let mut messages: Vec<(u64, u16, Value)> = Vec::new();
    let mut add = |channel: u16, of_row: &dyn Fn(usize) -> Option<Value>| {
        messages.extend(
            (0..recording.len()).filter_map(|row| Some((times_ns[row], channel, of_row(row)?))),
        );
    };
    let numbers = writer.channel(
        "/commands",
        "spinebench.Commands",
        &any_object("The commands from this time on."),
    );
    add(numbers, &|row| Some(commands(recording, row)));
    let rows = writer.channel(
        "/row",
        "spinebench.Row",
        &any_object("The other values in the row of the recording."),
    );
    add(rows, &|row| Some(other_cells(recording, row)));
    let mut pose = |topic: &str,
                    position_m: &dyn Fn(usize) -> Point3,
                    turn: &dyn Fn(usize) -> Option<[f64; 4]>| {
        let channel = writer.channel(topic, "foxglove.PoseInFrame", &pose_schema());
        add(channel, &|row| pose_in_frame(times_ns[row], position_m(row), turn(row)));
    };
    if let Some(tips_m) = &recording.tip_m {
        pose("/tip", &|row| tips_m[row], &|row| {
            recording.tip_quaternion.as_ref().map(|turns| turns[row])
        });
    }
    if let Some(base) = &recording.base {
        pose("/base", &|row| base[row].position_m, &|row| Some(base[row].quaternion));
    }
    for point in &recording.points {
        let turn = |row: usize| point.quaternion.as_ref().map(|turns| turns[row]);
        pose(&format!("/points/{}", point.name), &|row| point.position_m[row], &turn);
    }
    if let Some(shown) = shown.robot {
        let channel = writer.channel("/robot", "foxglove.SceneUpdate", &scene_schema());
        add(channel, &|row| robot::robot(times_ns[row], &shown.robot, &shown.frames[row]));
        let channel =
            writer.channel("/tf", "foxglove.FrameTransforms", &robot::transforms_schema());
        add(channel, &|row| robot::transforms(times_ns[row], &shown.frames[row]));
    }
    add_residuals(shown, &times_ns, &mut writer, &mut messages);
    messages.sort_by_key(|(time_ns, channel, _)| (*time_ns, *channel));
    messages
        .iter()
        .for_each(|(time_ns, channel, message)| writer.message(*channel, *time_ns, message));
    writer.finish()
}

/// Residuals as numbers, and as lines from the measured tip to where each model has it.
fn add_residuals(
    shown: &Shown,
    times_ns: &[u64],
    writer: &mut BagWriter,
    messages: &mut Vec<(u64, u16, Value)>,
) {
    if shown.residuals.is_empty() {
        return;
    }
    let recording = shown.recording;
    // Rows of a discovery's table are rounded: a sample is the nearest row of its trial.
    let trials: BTreeMap<u64, _> = recording.trials().into_iter().collect();
    let numbers = writer.channel(
        "/residuals",
        "spinebench.Residual",
        &any_object("Measured minus model, metres."),
    );
    let line_channel = writer.channel("/residual_lines", "foxglove.SceneUpdate", &scene_schema());
    for sample in shown.residuals {
        let Some(rows) = trials.get(&sample.trial) else { continue };
        let distance_s = |row: &usize| (recording.time_s[*row] - sample.time_s).abs();
        let Some(row) = rows.clone().min_by(|a, b| distance_s(a).total_cmp(&distance_s(b))) else {
            continue;
        };
        let time_ns = times_ns[row];
        let tip = [sample.tip_x_m, sample.tip_y_m, sample.tip_z_m];
        let (before, after) = (sample.before_m(), sample.after_m());
        if tip.iter().chain(&before).chain(&after).any(|x| !x.is_finite()) {
            continue;
        }
        let size = |residual: &Point3| residual.iter().map(|x| x * x).sum::<f64>().sqrt();
        let model = |residual: &Point3| -> Point3 {
            std::array::from_fn(|axis| tip[axis] - residual[axis])
        };
        messages.push((
            time_ns,
            numbers,
            json!({
                "timestamp": stamp(time_ns), "trial": sample.trial, "held_out": sample.held_out, "point": sample.point,
                "before_m": point(&before), "after_m": point(&after),
                "before_size_m": size(&before), "after_size_m": size(&after),
            }),
        ));
        let lines = [
            line(RESIDUAL_LINE_M, &[tip, model(&before)], BEFORE_COLOUR),
            line(RESIDUAL_LINE_M, &[tip, model(&after)], AFTER_COLOUR),
        ];
        messages.push((
            time_ns,
            line_channel,
            scene(time_ns, format!("residual {}", sample.point).trim_end(), &lines, &[]),
        ));
    }
}

/// Time of each row, nanoseconds, trials one after another.
fn times_ns(shown: &Shown) -> Vec<u64> {
    let recording = shown.recording;
    let mut start_s = 0.0;
    let mut times_ns = Vec::with_capacity(recording.len());
    for (_, rows) in recording.trials() {
        let last = rows.end - 1;
        let since = |row: usize| {
            if shown.at_rest { (row - rows.start) as f64 } else { recording.time_s[row] }
        };
        times_ns.extend(rows.clone().map(|row| ((start_s + since(row)) * 1e9).round() as u64));
        start_s += since(last) + PAUSE_S;
    }
    times_ns
}

pub(super) fn stamp(time_ns: u64) -> Value {
    json!({ "sec": time_ns / 1_000_000_000, "nsec": time_ns % 1_000_000_000 })
}

pub(super) fn point(point: &Point3) -> Value {
    json!({ "x": point[0], "y": point[1], "z": point[2] })
}

/// Unturned where there is no orientation; none where the position is unknown.
fn pose_in_frame(time_ns: u64, position_m: Point3, turn: Option<[f64; 4]>) -> Option<Value> {
    let [w, x, y, z] = turn
        .filter(|turn| turn.iter().all(|part| part.is_finite()))
        .unwrap_or([1.0, 0.0, 0.0, 0.0]);
    let pose = json!({ "position": point(&position_m), "orientation": { "x": x, "y": y, "z": z, "w": w } });
    let is_tracked = position_m.iter().all(|x| x.is_finite());
    is_tracked.then(|| json!({ "timestamp": stamp(time_ns), "frame_id": FRAME, "pose": pose }))
}

fn commands(recording: &Recording, row: usize) -> Value {
    let mut numbers = Map::new();
    for drive in &recording.drives {
        numbers.insert(drive.column(), drive.displacement[row].into());
    }
    if recording.drives.is_empty() {
        for (tendon, number) in recording.commands.row(row).iter().enumerate() {
            numbers.insert(recording.actuation.column(tendon), (*number).into());
        }
    }
    Value::Object(numbers)
}

/// Trial, time, validity, label and what the recording carries.
fn other_cells(recording: &Recording, row: usize) -> Value {
    let mut cells = Map::new();
    cells.insert("trial".into(), recording.trial[row].into());
    cells.insert("time_s".into(), recording.time_s[row].into());
    cells.insert("valid".into(), recording.is_valid(row).into());
    let load = recording.known_load_kg.iter().map(|all| ("known_load_kg", Value::from(all[row])));
    let label = recording.pattern.iter().map(|all| ("pattern", Value::from(all[row].clone())));
    cells.extend(load.chain(label).map(|(name, cell)| (name.to_owned(), cell)));
    for (name, column) in &recording.extra {
        let cell = match column {
            Extra::Integers(column) => column[row].into(),
            Extra::Numbers(column) => column[row].into(),
            // What a CSV carries is text, numbers too.
            Extra::Text(column) => match column[row].trim().parse::<f64>() {
                Ok(number) if number.is_finite() => number.into(),
                _ => column[row].clone().into(),
            },
        };
        cells.insert(name.clone(), cell);
    }
    Value::Object(cells)
}

/// A line of `foxglove.SceneUpdate` through all points.
pub(super) fn line(thickness_m: f64, points_m: &[Point3], [r, g, b]: [f64; 3]) -> Value {
    let unturned = json!({ "position": point(&[0.0; 3]), "orientation": { "x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0 } });
    json!({
        "type": LINE_STRIP, "pose": unturned, "thickness": thickness_m, "scale_invariant": false,
        "points": points_m.iter().map(point).collect::<Vec<Value>>(),
        "color": { "r": r, "g": g, "b": b, "a": 1.0 }, "colors": [], "indices": [],
    })
}

/// A scene of one entity, which replaces the one before.
pub(super) fn scene(time_ns: u64, id: &str, lines: &[Value], cylinders: &[Value]) -> Value {
    let entity = json!({
        "timestamp": stamp(time_ns), "frame_id": FRAME, "id": id, "lifetime": { "sec": 0, "nsec": 0 },
        "frame_locked": false, "metadata": [], "arrows": [], "cubes": [], "spheres": [], "cylinders": cylinders,
        "lines": lines, "triangles": [], "texts": [], "models": [],
    });
    json!({ "deletions": [], "entities": [entity] })
}

fn any_object(description: &str) -> Value {
    json!({ "type": "object", "description": description, "additionalProperties": true })
}

pub(super) fn object(properties: &Value) -> Value {
    json!({ "type": "object", "properties": properties })
}

pub(super) fn numbers_of(names: &[&str]) -> Value {
    let each = names.iter().map(|name| ((*name).to_owned(), json!({ "type": "number" })));
    object(&Value::Object(each.collect()))
}

pub(super) fn time_schema() -> Value {
    object(
        &json!({ "sec": { "type": "integer", "minimum": 0 }, "nsec": { "type": "integer", "minimum": 0 } }),
    )
}

fn pose_parts() -> Value {
    object(
        &json!({ "position": numbers_of(&["x", "y", "z"]), "orientation": numbers_of(&["x", "y", "z", "w"]) }),
    )
}

fn pose_schema() -> Value {
    let mut schema = object(
        &json!({ "timestamp": time_schema(), "frame_id": { "type": "string" }, "pose": pose_parts() }),
    );
    schema["title"] = "foxglove.PoseInFrame".into();
    schema
}

fn scene_schema() -> Value {
    let list = |items: &Value| json!({ "type": "array", "items": items });
    let color = numbers_of(&["r", "g", "b", "a"]);
    let line = object(&json!({
        "type": { "type": "integer" }, "pose": pose_parts(), "thickness": { "type": "number" },
        "scale_invariant": { "type": "boolean" }, "points": list(&numbers_of(&["x", "y", "z"])), "color": color,
        "colors": list(&color), "indices": list(&json!({ "type": "integer" })),
    }));
    let cylinder = object(&json!({
        "pose": pose_parts(), "size": numbers_of(&["x", "y", "z"]), "bottom_scale": { "type": "number" },
        "top_scale": { "type": "number" }, "color": color,
    }));
    let other = list(&json!({ "type": "object" }));
    let entity = object(&json!({
        "timestamp": time_schema(), "frame_id": { "type": "string" }, "id": { "type": "string" }, "lifetime": time_schema(),
        "frame_locked": { "type": "boolean" }, "metadata": other, "arrows": other, "cubes": other, "spheres": other,
        "cylinders": list(&cylinder), "lines": list(&line), "triangles": other, "texts": other, "models": other,
    }));
    let mut schema = object(&json!({ "deletions": other, "entities": list(&entity) }));
    schema["title"] = "foxglove.SceneUpdate".into();
    schema
}
