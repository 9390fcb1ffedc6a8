//! Scenes: a robot and its motion as viewers draw it, as compact JSON.

use serde::{Deserialize, Serialize};

use crate::base::{Point3, distance_m};

/// A robot in motion.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// What it shows, in a few words.
    pub name: String,
    /// The robot.
    pub robot: SceneRobot,
    /// Its poses in the order of time.
    pub frames: Vec<SceneFrame>,
}

/// What does not move within a scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneRobot {
    /// Length of the unloaded backbone, metres.
    pub length_m: f64,
    /// Unit vector against gravity; along x without gravity.
    pub up: Point3,
    /// Cross-sections from base to tip of which frames hold the poses; none where only a tip was
    /// measured.
    pub stations: Vec<SceneStation>,
    /// The tendons.
    pub tendons: Vec<SceneTendon>,
    /// What the robot may touch.
    pub obstacles: Vec<SceneObstacle>,
}

/// A cross-section.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneStation {
    /// Distance from the base along the unloaded backbone, metres.
    pub s_m: f64,
    /// Radius of the backbone, metres.
    pub radius_m: f64,
    /// Radius of the disk, metres; 0 without a disk.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub disk_radius_m: f64,
    /// Thickness of the disk, metres; 0 where the model has none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub disk_thickness_m: f64,
}

/// A tendon.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneTendon {
    /// Index of the station at which it leaves its sheath.
    pub first: usize,
    /// Offset from the backbone along x and y of the cross-section, metres, at each station from
    /// there to its anchor.
    pub holes_m: Vec<[f64; 2]>,
}

/// Shape and place of an obstacle, world frame, metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SceneObstacle {
    /// All points p with `normal`·p ≤ `offset_m`.
    HalfSpace {
        /// Unit vector out of the obstacle.
        normal: Point3,
        /// Distance of the plane from the origin along the normal.
        offset_m: f64,
    },
    /// A ball.
    Sphere {
        /// Its centre.
        center_m: Point3,
        /// Its radius.
        radius_m: f64,
    },
    /// A round rod between two points.
    Rod {
        /// The ends of its axis.
        ends_m: [Point3; 2],
        /// Its radius.
        radius_m: f64,
        /// Whether hemispheres close it.
        round: bool,
    },
}

/// The pose at one instant.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneFrame {
    /// Time, seconds.
    pub time_s: f64,
    /// Tip of the robot, metres; none where the solver found no solution.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tip_m: Option<Point3>,
    /// Pose of each station; none where the solver found no solution.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub poses: Vec<StationPose>,
    /// Tension of each tendon, newtons; 0 when slack.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tensions_n: Vec<f64>,
    /// Where the tip shall go, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target_m: Option<Point3>,
    /// Measured tip, then further measured points, metres.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub measured_m: Vec<Point3>,
}

/// Position and orientation of a cross-section, world frame. As JSON: tenths of a millimetre
/// (x, y, z) and thousandths of the quaternion (w, x, y, z).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "[i32; 7]", into = "[i32; 7]")]
pub struct StationPose {
    position_m: Point3,
    quaternion: [f64; 4],
}

/// Tenths of a millimetre in a metre.
const POSITION_UNITS: f64 = 1e4;
/// Thousandths in one.
const QUATERNION_UNITS: f64 = 1e3;
/// Digits of a metre that points keep: hundredths of a millimetre.
const POINT_UNITS: f64 = 1e5;
/// Digits of a newton that tensions keep.
const TENSION_UNITS: f64 = 1e2;

impl StationPose {
    /// A pose with all its digits.
    pub fn new(position_m: Point3, quaternion: [f64; 4]) -> StationPose {
        StationPose { position_m, quaternion }
    }

    /// The pose as it is after its JSON.
    #[must_use]
    pub fn rounded(self) -> StationPose {
        <[i32; 7]>::from(self).into()
    }

    /// Position, metres.
    pub fn position_m(&self) -> Point3 {
        self.position_m
    }

    /// Axes x, y and z of the cross-section.
    pub fn axes(&self) -> [Point3; 3] {
        let [w, x, y, z] = self.quaternion();
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
            [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
            [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    }

    /// A place given along the axes of the cross-section, metres.
    pub fn place_m(&self, along_m: [f64; 3]) -> Point3 {
        let (at, axes) = (self.position_m(), self.axes());
        std::array::from_fn(|k| {
            at[k] + (0..3).map(|axis| along_m[axis] * axes[axis][k]).sum::<f64>()
        })
    }

    /// Orientation as a unit quaternion w, x, y, z.
    pub fn quaternion(&self) -> [f64; 4] {
        let parts = self.quaternion;
        let norm = parts.iter().map(|part| part * part).sum::<f64>().sqrt();
        if norm > 0.0 { parts.map(|part| part / norm) } else { [1.0, 0.0, 0.0, 0.0] }
    }
}

impl From<StationPose> for [i32; 7] {
    fn from(pose: StationPose) -> [i32; 7] {
        let [x, y, z] = pose.position_m.map(|x| (x * POSITION_UNITS).round() as i32);
        let [w, i, j, k] = pose.quaternion.map(|part| (part * QUATERNION_UNITS).round() as i32);
        [x, y, z, w, i, j, k]
    }
}

impl From<[i32; 7]> for StationPose {
    fn from([x, y, z, w, i, j, k]: [i32; 7]) -> StationPose {
        StationPose {
            position_m: [x, y, z].map(|x| f64::from(x) / POSITION_UNITS),
            quaternion: [w, i, j, k].map(|part| f64::from(part) / QUATERNION_UNITS),
        }
    }
}

/// A place on the backbone between two stations, `share` of the way: a cubic Hermite spline by the
/// tangents at its ends, metres.
pub fn between_stations_m(from: &StationPose, to: &StationPose, share: f64) -> Point3 {
    let (start, end) = (from.position_m(), to.position_m());
    let chord_m = distance_m(&start, &end);
    let (t, t2, t3) = (share, share * share, share * share * share);
    let weights = [2.0 * t3 - 3.0 * t2 + 1.0, 3.0 * t2 - 2.0 * t3];
    let slopes = [t3 - 2.0 * t2 + t, t3 - t2].map(|weight| weight * chord_m);
    let (out, back) = (from.axes()[2], to.axes()[2]);
    std::array::from_fn(|k| {
        weights[0] * start[k] + weights[1] * end[k] + slopes[0] * out[k] + slopes[1] * back[k]
    })
}

impl SceneFrame {
    /// The frame without points that are not finite.
    #[must_use]
    pub fn finite(mut self) -> SceneFrame {
        let seen = |point: &Point3| point.iter().all(|x| x.is_finite());
        self.tip_m = self.tip_m.filter(seen);
        self.target_m = self.target_m.filter(seen);
        self.measured_m.retain(seen);
        self
    }

    /// The frame with its numbers rounded to what can be seen, for a page or a picture; points
    /// that are not finite are left out.
    #[must_use]
    pub fn rounded(self) -> SceneFrame {
        let point = |point: Point3| point.map(|x| rounded(x, POINT_UNITS));
        let mut this = self.finite();
        this.time_s = rounded(this.time_s, 1e3);
        this.tip_m = this.tip_m.map(point);
        this.target_m = this.target_m.map(point);
        this.poses.iter_mut().for_each(|pose| *pose = pose.rounded());
        this.measured_m.iter_mut().for_each(|measured| *measured = point(*measured));
        this.tensions_n.iter_mut().for_each(|tension| *tension = rounded(*tension, TENSION_UNITS));
        this
    }
}

impl Scene {
    /// The scene as a page or a picture carries it.
    #[must_use]
    pub fn rounded(mut self) -> Scene {
        self.frames = self.frames.into_iter().map(SceneFrame::rounded).collect();
        self
    }

    /// The scene with at most `count` frames, evenly chosen, the first and the last among them.
    #[must_use]
    pub fn thinned(mut self, count: usize) -> Scene {
        let (frames, last) = (self.frames.len(), self.frames.len().saturating_sub(1));
        if frames > count && count > 1 {
            self.frames = (0..count).map(|k| self.frames[k * last / (count - 1)].clone()).collect();
        }
        self
    }

    /// Time of the last frame, seconds.
    pub fn duration_s(&self) -> f64 {
        self.frames.last().map_or(0.0, |frame| frame.time_s)
    }
}

fn rounded(value: f64, units: f64) -> f64 {
    // Adding 0 makes −0 a 0.
    (value * units).round() / units + 0.0
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_survives_its_json() {
        let pose = StationPose::new([0.01234, -0.1, 0.2], [0.5, -0.5, 0.5, 0.5]);
        assert_eq!(pose.position_m(), [0.01234, -0.1, 0.2]);
        let pose = pose.rounded();
        assert_eq!(pose.position_m(), [0.0123, -0.1, 0.2]);
        assert_eq!(pose.quaternion(), [0.5, -0.5, 0.5, 0.5]);
        let frame = SceneFrame {
            time_s: 0.2,
            tip_m: Some([0.123_456_7, -1e-9, 0.2]),
            poses: vec![pose],
            tensions_n: vec![1.234_5, 0.0],
            target_m: None,
            measured_m: vec![[f64::NAN; 3], [0.1, 0.2, 0.3]],
        };
        let frame = frame.rounded();
        assert_eq!(frame.tip_m, Some([0.123_46, 0.0, 0.2]));
        assert_eq!(frame.measured_m, [[0.1, 0.2, 0.3]]);
        let obstacles = vec![
            SceneObstacle::HalfSpace { normal: [1.0, 0.0, 0.0], offset_m: -0.1 },
            SceneObstacle::Sphere { center_m: [0.1; 3], radius_m: 0.02 },
            SceneObstacle::Rod { ends_m: [[0.0; 3], [0.1; 3]], radius_m: 0.01, round: true },
        ];
        let station = SceneStation { s_m: 0.1, radius_m: 0.002, ..SceneStation::default() };
        let robot = SceneRobot { stations: vec![station], obstacles, ..SceneRobot::default() };
        let scene = Scene { name: "A".to_owned(), robot, frames: vec![frame; 5] };
        let json = serde_json::to_string(&scene).unwrap();
        assert_eq!(serde_json::from_str::<Scene>(&json).unwrap(), scene);
        assert_eq!(scene.thinned(2).frames.len(), 2);
    }
}
