//! Poses, and the way from two tracked bodies to the tip in the robot's base frame.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::settings::{TrackingSettings, UpAxis};
use crate::base::{BadOption, Point3};
use crate::math::rotation;

/// Quaternions whose length is further from 1 are refused rather than normalised.
const UNIT_TOLERANCE: f64 = 1e-3;

/// A position and an orientation: where a frame is, seen from another one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Pose {
    /// Position, metres.
    pub position_m: Point3,
    /// Orientation as a unit quaternion (w, x, y, z).
    pub quaternion: [f64; 4],
}

impl Default for Pose {
    fn default() -> Self {
        Pose { position_m: [0.0; 3], quaternion: [1.0, 0.0, 0.0, 0.0] }
    }
}

impl Pose {
    /// A pose without rotation.
    pub fn at(position_m: Point3) -> Pose {
        Pose { position_m, ..Pose::default() }
    }

    /// The pose of a rigid motion; its quaternion has w ≥ 0.
    pub fn of(motion: &Isometry3<f64>) -> Pose {
        Pose { position_m: motion.translation.vector.into(), quaternion: rotation::parts(&motion.rotation) }
    }

    /// The rigid motion of this pose; the quaternion is normalised.
    pub fn motion(&self) -> Isometry3<f64> {
        let [w, x, y, z] = self.quaternion;
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        Isometry3::from_parts(Translation3::from(Vector3::from(self.position_m)), turn)
    }

    /// The pose at `fraction` of the way to `other`: straight in position, at constant rate about one axis in rotation.
    pub fn towards(&self, other: &Pose, fraction: f64) -> Pose {
        let (from, to) = (self.motion(), other.motion());
        let turn = rotation::between(&from.rotation, &to.rotation, fraction);
        let position = from.translation.vector.lerp(&to.translation.vector, fraction);
        Pose::of(&Isometry3::from_parts(position.into(), turn))
    }

    /// Refuses numbers that are not finite and quaternions that are not of length 1; `key` is where the pose stands.
    ///
    /// # Errors
    /// [`BadOption`].
    pub fn check(&self, key: &'static str) -> Result<(), BadOption> {
        let length = self.quaternion.iter().map(|value| value * value).sum::<f64>().sqrt();
        let finite = self.position_m.iter().all(|value| value.is_finite());
        if finite && (length - 1.0).abs() <= UNIT_TOLERANCE {
            return Ok(());
        }
        let found = format!("position_m {:?}, quaternion {:?}", self.position_m, self.quaternion);
        Err(BadOption { key, found, expected: "a finite position and a quaternion (w, x, y, z) of length 1" })
    }
}

/// Where the tip was at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipPose {
    /// Local time, s.
    pub time_s: f64,
    /// Position in the robot's base frame, metres.
    pub position_m: Point3,
    /// Orientation in the robot's base frame: unit quaternion (w, x, y, z), w ≥ 0.
    pub quaternion: [f64; 4],
}

impl TipPose {
    pub(super) fn new(time_s: f64, pose: Pose) -> TipPose {
        TipPose { time_s, position_m: pose.position_m, quaternion: pose.quaternion }
    }

    /// The same without its time.
    pub fn pose(&self) -> Pose {
        Pose { position_m: self.position_m, quaternion: self.quaternion }
    }
}

/// How the tracked bodies are fixed to the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounting {
    /// From Motive's axes to those of the harness.
    axes: UnitQuaternion<f64>,
    /// The robot's base frame in the base body's frame.
    base: Isometry3<f64>,
    /// The robot's tip in the tip body's frame.
    tip: Isometry3<f64>,
}

impl Mounting {
    /// The mounting that the settings describe.
    pub fn of(settings: &TrackingSettings) -> Mounting {
        let axes = match settings.up_axis {
            UpAxis::Y => UnitQuaternion::from_scaled_axis(Vector3::z() * -std::f64::consts::FRAC_PI_2),
            UpAxis::Z => UnitQuaternion::from_quaternion(Quaternion::new(0.0, 1.0, 0.0, 1.0)),
        };
        Mounting { axes, base: settings.alignment.motion(), tip: settings.tip_offset.motion() }
    }

    /// The tip in the robot's base frame, from the two bodies as Motive sees them. Where Motive's origin is drops out.
    pub fn tip(&self, base_body: &Pose, tip_body: &Pose) -> Pose {
        let seen = base_body.motion().inv_mul(&tip_body.motion());
        let turned = self.axes * seen * self.axes.inverse();
        Pose::of(&(self.base.inv_mul(&turned) * self.tip))
    }

    /// The tip body as Motive sees it when the tip is at `tip` in the robot's base frame: the opposite of
    /// [`Mounting::tip`].
    pub fn tip_body(&self, base_body: &Pose, tip: &Pose) -> Pose {
        let turned = self.base * tip.motion() * self.tip.inverse();
        let seen = self.axes.inverse() * turned * self.axes;
        Pose::of(&(base_body.motion() * seen))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_of_motive_is_x_and_the_straight_robot_is_z() {
        let seen = |up_axis, body_m| {
            let settings = TrackingSettings { up_axis, ..TrackingSettings::default() };
            Vector3::from(Mounting::of(&settings).tip(&Pose::default(), &Pose::at(body_m)).position_m)
        };
        assert!((seen(UpAxis::Y, [0.0, 1.0, 0.0]) - Vector3::x()).norm() < 1e-15);
        assert!((seen(UpAxis::Y, [0.0, 0.0, 1.0]) - Vector3::z()).norm() < 1e-15);
        assert!((seen(UpAxis::Z, [0.0, 0.0, 1.0]) - Vector3::x()).norm() < 1e-15);
        assert!((seen(UpAxis::Z, [1.0, 0.0, 0.0]) - Vector3::z()).norm() < 1e-15);
    }
}
