//! Poses: a frame relative to another one, and the tip at one time.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::base::{BadOption, Point3};
use crate::math::rotation;

/// Largest deviation of a quaternion's norm from 1; others are refused rather than normalised.
const UNIT_TOLERANCE: f64 = 1e-3;

/// A position and an orientation: the pose of a frame relative to another one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RigidPose {
    /// Position, metres.
    pub position_m: Point3,
    /// Orientation as a unit quaternion (w, x, y, z).
    pub quaternion: [f64; 4],
}

impl Default for RigidPose {
    fn default() -> Self {
        RigidPose { position_m: [0.0; 3], quaternion: [1.0, 0.0, 0.0, 0.0] }
    }
}

impl RigidPose {
    /// A pose without rotation.
    pub fn at(position_m: Point3) -> RigidPose {
        RigidPose { position_m, ..RigidPose::default() }
    }

    /// The pose of a rigid motion; its quaternion has w ≥ 0.
    pub fn of(motion: &Isometry3<f64>) -> RigidPose {
        RigidPose {
            position_m: motion.translation.vector.into(),
            quaternion: rotation::parts(&motion.rotation),
        }
    }

    /// The rigid motion of this pose; the quaternion is normalised.
    pub fn motion(&self) -> Isometry3<f64> {
        let [w, x, y, z] = self.quaternion;
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        Isometry3::from_parts(Translation3::from(Vector3::from(self.position_m)), turn)
    }

    /// The pose at `fraction` of the way to `other`: linear in position, constant angular rate
    /// about one axis.
    pub fn towards(&self, other: &RigidPose, fraction: f64) -> RigidPose {
        let (from, to) = (self.motion(), other.motion());
        let turn = rotation::between(&from.rotation, &to.rotation, fraction);
        let position = from.translation.vector.lerp(&to.translation.vector, fraction);
        RigidPose::of(&Isometry3::from_parts(position.into(), turn))
    }

    /// Refuses values that are not finite and quaternions whose norm is not 1; `key` names the
    /// setting.
    ///
    /// # Errors
    /// [`BadOption`].
    pub fn check(&self, key: &'static str) -> Result<(), BadOption> {
        let length = self.quaternion.iter().map(|value| value * value).sum::<f64>().sqrt();
        let finite = self.position_m.iter().all(|value| value.is_finite());
        let valid = finite && (length - 1.0).abs() <= UNIT_TOLERANCE;
        let found = format!("position_m {:?}, quaternion {:?}", self.position_m, self.quaternion);
        BadOption::unless(
            valid,
            key,
            found,
            "a finite position and a quaternion (w, x, y, z) of length 1",
        )
    }
}

/// Pose of the tip at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipPose {
    /// The tracker's clock, s.
    pub stamp_s: f64,
    /// Local time, s: moves with the estimate of the clock offset.
    pub time_s: f64,
    /// Position in the robot's base frame, metres.
    pub position_m: Point3,
    /// Orientation in the robot's base frame: unit quaternion (w, x, y, z), w ≥ 0.
    pub quaternion: [f64; 4],
}

impl TipPose {
    pub(super) fn new(stamp_s: f64, time_s: f64, pose: RigidPose) -> TipPose {
        TipPose { stamp_s, time_s, position_m: pose.position_m, quaternion: pose.quaternion }
    }

    /// The pose without its time.
    pub fn pose(&self) -> RigidPose {
        RigidPose { position_m: self.position_m, quaternion: self.quaternion }
    }
}
