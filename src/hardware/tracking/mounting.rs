//! From two tracked bodies to the tip in the robot's base frame.

use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};

use super::pose::RigidPose;
use super::settings::{TrackingSettings, UpAxis};

/// Mounting of the tracked bodies on the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounting {
    /// From Motive's axes to those of this program.
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
            // Motive's y becomes x and its z stays: −90° about z.
            UpAxis::Y => {
                UnitQuaternion::from_scaled_axis(Vector3::z() * -std::f64::consts::FRAC_PI_2)
            }
            // Motive's z becomes x and its x becomes z: 180° about the bisector is no mirror.
            UpAxis::Z => UnitQuaternion::from_quaternion(Quaternion::new(0.0, 1.0, 0.0, 1.0)),
        };
        Mounting { axes, base: settings.alignment.motion(), tip: settings.tip_offset.motion() }
    }

    /// The tip in the robot's base frame, from the poses of the two bodies in Motive. Motive's
    /// origin cancels out.
    pub fn tip(&self, base_body: &RigidPose, tip_body: &RigidPose) -> RigidPose {
        let tip_in_base = base_body.motion().inv_mul(&tip_body.motion());
        let turned = self.axes * tip_in_base * self.axes.inverse();
        RigidPose::of(&(self.base.inv_mul(&turned) * self.tip))
    }

    /// The tip body in Motive when the tip is at `tip` in the robot's base frame: the inverse of
    /// [`Mounting::tip`].
    pub fn tip_body(&self, base_body: &RigidPose, tip: &RigidPose) -> RigidPose {
        let turned = self.base * tip.motion() * self.tip.inverse();
        let tip_in_base = self.axes.inverse() * turned * self.axes;
        RigidPose::of(&(base_body.motion() * tip_in_base))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_of_motive_is_x_and_the_straight_robot_is_z() {
        let seen = |up_axis, body_m| {
            let settings = TrackingSettings { up_axis, ..TrackingSettings::default() };
            Vector3::from(
                Mounting::of(&settings)
                    .tip(&RigidPose::default(), &RigidPose::at(body_m))
                    .position_m,
            )
        };
        assert!((seen(UpAxis::Y, [0.0, 1.0, 0.0]) - Vector3::x()).norm() < 1e-15);
        assert!((seen(UpAxis::Y, [0.0, 0.0, 1.0]) - Vector3::z()).norm() < 1e-15);
        assert!((seen(UpAxis::Z, [0.0, 0.0, 1.0]) - Vector3::x()).norm() < 1e-15);
        assert!((seen(UpAxis::Z, [1.0, 0.0, 0.0]) - Vector3::z()).norm() < 1e-15);
    }
}
