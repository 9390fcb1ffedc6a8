//! The robot of a model as viewers draw it, and its pose at one instant.

use nalgebra::Vector3;

use crate::base::{Observation, Point3};
use crate::data::scene::{
    SceneFrame, SceneObstacle, SceneRobot, SceneStation, SceneTendon, StationPose,
};
use crate::effects::{BodyPoint, Model};
use crate::rod::{ObstacleShape, RodParams, Tendon};

/// Stations are at most this share of the length apart.
const MAX_STEP: f64 = 0.1;
/// Places nearer than this share of the length are one.
const SAME_PLACE: f64 = 1e-6;
/// Upper bound on the disks that are drawn.
const MAX_DISKS: usize = 200;
/// Radius of a disk over the distance of its outermost hole.
const RIM: f64 = 1.2;
/// Half of an obstacle without end, in lengths of the robot.
const REACH: f64 = 3.0;

/// The robot of a checked model.
pub fn scene_robot(model: &Model) -> SceneRobot {
    let rod = model.rod(&[]);
    let stations = stations(model, &rod);
    let tendons = rod.tendons.iter().map(|tendon| drawn_tendon(tendon, &stations)).collect();
    let obstacles = rod.contact.obstacles.iter();
    let up = -rod.gravity_m_s2;
    SceneRobot {
        length_m: rod.length_m(),
        up: up.try_normalize(0.0).unwrap_or_else(Vector3::x).map(|x| x + 0.0).into(),
        tendons,
        obstacles: obstacles.map(|one| drawn_obstacle(&one.shape, rod.length_m())).collect(),
        stations,
    }
}

/// The model with the stations of `robot`, in their order, in place of its tracked points.
pub fn tracked_at_stations(model: &Model, robot: &SceneRobot) -> Model {
    let mut model = model.clone();
    let places = robot.stations.iter().enumerate();
    // The order of the names is that of the stations.
    let place = |(k, station): (usize, &SceneStation)| {
        (format!("station_{k:04}"), BodyPoint { s_m: station.s_m, offset_m: [0.0; 3] })
    };
    model.tracking.points = places.map(place).collect();
    model
}

/// The frame of an observation of such a model.
pub fn scene_frame(seen: &Observation) -> SceneFrame {
    let poses = seen.points.iter().map(|point| {
        StationPose::new(point.position_m, point.quaternion.unwrap_or([1.0, 0.0, 0.0, 0.0]))
    });
    SceneFrame {
        time_s: seen.time_s,
        tip_m: Some(seen.tip_m),
        poses: poses.collect(),
        tensions_n: seen.tensions_n.clone().unwrap_or_default(),
        ..SceneFrame::default()
    }
}

/// Base, disks, ends of tendons and tip, with further cross-sections where these are far apart.
fn stations(model: &Model, rod: &RodParams) -> Vec<SceneStation> {
    let (robot, length_m) = (&model.robot, rod.length_m());
    let at = |s_m: f64| SceneStation {
        s_m,
        radius_m: robot.backbone.radius_at_m(s_m),
        ..SceneStation::default()
    };
    let places_m = robot.disk_places_m(rod);
    let disks = places_m.iter().step_by(places_m.len().div_ceil(MAX_DISKS).max(1));
    let mut stations: Vec<SceneStation> = disks
        .map(|[start_m, end_m]| {
            let s_m = 0.5 * (start_m + end_m);
            SceneStation {
                disk_radius_m: robot.disks.contact_radius_m.unwrap_or(RIM * outermost_m(rod, s_m)),
                disk_thickness_m: end_m - start_m,
                ..at(s_m)
            }
        })
        .collect();
    let ends_m = rod.tendons.iter().flat_map(|tendon| [tendon.start_m, tendon.end_m]);
    for s_m in ends_m.chain([0.0, length_m]) {
        if stations.iter().all(|station| (station.s_m - s_m).abs() > SAME_PLACE * length_m) {
            stations.push(at(s_m));
        }
    }
    stations.sort_by(|one, other| one.s_m.total_cmp(&other.s_m));
    let between = |pair: &[SceneStation]| {
        let (from_m, step_m) = (pair[0].s_m, pair[1].s_m - pair[0].s_m);
        let parts = (step_m / (MAX_STEP * length_m) - SAME_PLACE).ceil().max(1.0);
        (1..parts as usize).map(|k| at(from_m + step_m * k as f64 / parts)).collect::<Vec<_>>()
    };
    let more: Vec<SceneStation> = stations.windows(2).flat_map(between).collect();
    stations.extend(more);
    stations.iter_mut().for_each(round);
    stations.sort_by(|one, other| one.s_m.total_cmp(&other.s_m));
    stations
}

/// Distance of the outermost tendon from the backbone where a disk holds it, metres; that of the
/// outermost tendon at all where none passes.
fn outermost_m(rod: &RodParams, s_m: f64) -> f64 {
    let distance_m = |tendon: &Tendon| {
        let [x, y] = tendon.path.at(s_m).0;
        x.hypot(y)
    };
    let slack_m = SAME_PLACE * rod.length_m();
    let passes =
        |tendon: &&Tendon| tendon.start_m <= s_m + slack_m && s_m <= tendon.end_m + slack_m;
    let passing_m = rod.tendons.iter().filter(passes).map(distance_m).fold(0.0, f64::max);
    if passing_m > 0.0 { passing_m } else { rod.tendons.iter().map(distance_m).fold(0.0, f64::max) }
}

/// Digits that can be seen, which keep the JSON short; places to ten nanometres.
fn round(station: &mut SceneStation) {
    station.s_m = (station.s_m * 1e8).round() / 1e8;
    station.radius_m = to_hundredths_mm(station.radius_m);
    station.disk_radius_m = to_hundredths_mm(station.disk_radius_m);
    station.disk_thickness_m = to_hundredths_mm(station.disk_thickness_m);
}

fn drawn_tendon(tendon: &Tendon, stations: &[SceneStation]) -> SceneTendon {
    let slack_m = SAME_PLACE * stations.last().map_or(0.0, |station| station.s_m);
    let passes = |station: &&SceneStation| {
        station.s_m >= tendon.start_m - slack_m && station.s_m <= tendon.end_m + slack_m
    };
    let first = stations.iter().position(|station| passes(&station)).unwrap_or_default();
    let holes_m = stations.iter().filter(passes).map(|station| tendon.path.at(station.s_m).0);
    SceneTendon { first, holes_m: holes_m.map(|hole| hole.map(to_hundredths_mm)).collect() }
}

fn to_hundredths_mm(length_m: f64) -> f64 {
    (length_m * 1e5).round() / 1e5 + 0.0
}

fn drawn_obstacle(shape: &ObstacleShape, length_m: f64) -> SceneObstacle {
    match shape {
        ObstacleShape::HalfSpace { normal, offset_m } => {
            SceneObstacle::HalfSpace { normal: (*normal).into(), offset_m: *offset_m }
        }
        ObstacleShape::Sphere { center_m, radius_m } => {
            SceneObstacle::Sphere { center_m: (*center_m).into(), radius_m: *radius_m }
        }
        ObstacleShape::Cylinder { center_m, axis, radius_m, length_m: own_m } => {
            let half = axis * (0.5 * own_m).min(REACH * length_m);
            let ends_m: [Point3; 2] = [(center_m - half).into(), (center_m + half).into()];
            SceneObstacle::Rod { ends_m, radius_m: *radius_m, round: false }
        }
        ObstacleShape::Capsule { ends_m, radius_m } => {
            SceneObstacle::Rod { ends_m: ends_m.map(Into::into), radius_m: *radius_m, round: true }
        }
    }
}
