//! The robot of a scene as messages of viewers: what is drawn, and a frame for each cross-section.

use serde_json::{Value, json};

use super::export::{FRAME, line, numbers_of, object, point, scene, stamp, time_schema};
use crate::base::Point3;
use crate::data::scene::{SceneFrame, SceneRobot, StationPose, between_stations_m};

/// Pieces of the backbone between two stations.
const PIECES: usize = 4;
/// Thickness of a tendon's line, metres.
const TENDON_M: f64 = 1e-3;
/// Thickness of a disk over its radius where the model has none.
const THIN: f64 = 0.08;
/// Colours, red to blue.
const BACKBONE: [f64; 3] = [0.2, 0.4, 0.9];
const TAUT: [f64; 3] = [0.76, 0.29, 0.0];
const SLACK: [f64; 3] = [0.44, 0.48, 0.53];

/// `foxglove.SceneUpdate`: backbone and tendons as lines, disks as cylinders; none where the solver
/// found no solution.
pub(super) fn robot(time_ns: u64, robot: &SceneRobot, frame: &SceneFrame) -> Option<Value> {
    let last = frame.poses.last()?;
    let piece = |pair: &[StationPose]| -> Vec<Point3> {
        (0..PIECES)
            .map(|k| between_stations_m(&pair[0], &pair[1], k as f64 / PIECES as f64))
            .collect()
    };
    let mut backbone: Vec<Point3> = frame.poses.windows(2).flat_map(piece).collect();
    backbone.push(last.position_m());
    let thickness_m = 2.0 * robot.stations.first()?.radius_m;
    let mut lines = vec![line(thickness_m, &backbone, BACKBONE)];
    for (tendon, tension_n) in robot.tendons.iter().zip(&frame.tensions_n) {
        let holes = tendon.holes_m.iter().zip(frame.poses.iter().skip(tendon.first));
        let places: Vec<Point3> = holes.map(|([x, y], pose)| pose.place_m([*x, *y, 0.0])).collect();
        lines.push(line(TENDON_M, &places, if *tension_n > 0.0 { TAUT } else { SLACK }));
    }
    let disks = robot.stations.iter().zip(&frame.poses).filter(|(one, _)| one.disk_radius_m > 0.0);
    let cylinders = disks.map(|(station, pose)| {
        let wide_m = 2.0 * station.disk_radius_m;
        let thick_m = station.disk_thickness_m.max(THIN * station.disk_radius_m);
        json!({
            "pose": { "position": point(&pose.position_m()), "orientation": orientation(pose) },
            "size": { "x": wide_m, "y": wide_m, "z": thick_m }, "bottom_scale": 1.0, "top_scale": 1.0,
            "color": { "r": 0.62, "g": 0.77, "b": 0.87, "a": 0.6 },
        })
    });
    Some(scene(time_ns, "robot", &lines, &cylinders.collect::<Vec<Value>>()))
}

/// `foxglove.FrameTransforms`: the frame `station_K` of each cross-section, from 0 at the base.
pub(super) fn transforms(time_ns: u64, frame: &SceneFrame) -> Option<Value> {
    let transform = |(k, pose): (usize, &StationPose)| {
        json!({
            "timestamp": stamp(time_ns), "parent_frame_id": FRAME, "child_frame_id": format!("station_{k}"),
            "translation": point(&pose.position_m()), "rotation": orientation(pose),
        })
    };
    let all: Vec<Value> = frame.poses.iter().enumerate().map(transform).collect();
    (!all.is_empty()).then(|| json!({ "transforms": all }))
}

fn orientation(pose: &StationPose) -> Value {
    let [w, x, y, z] = pose.quaternion();
    json!({ "x": x, "y": y, "z": z, "w": w })
}

pub(super) fn transforms_schema() -> Value {
    let transform = object(&json!({
        "timestamp": time_schema(), "parent_frame_id": { "type": "string" }, "child_frame_id": { "type": "string" },
        "translation": numbers_of(&["x", "y", "z"]), "rotation": numbers_of(&["x", "y", "z", "w"]),
    }));
    let mut schema = object(&json!({ "transforms": { "type": "array", "items": transform } }));
    schema["title"] = "foxglove.FrameTransforms".into();
    schema
}
