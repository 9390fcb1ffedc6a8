//! Orientations from Euler angles.

use nalgebra::{UnitQuaternion, Vector3};

use super::map::{EulerMap, EulerOrder, EulerRotation};
use crate::math::rotation;

impl EulerOrder {
    /// The axes, 0 for x.
    fn axes(self) -> [usize; 3] {
        match self {
            EulerOrder::Xyz => [0, 1, 2],
            EulerOrder::Xzy => [0, 2, 1],
            EulerOrder::Yxz => [1, 0, 2],
            EulerOrder::Yzx => [1, 2, 0],
            EulerOrder::Zxy => [2, 0, 1],
            EulerOrder::Zyx => [2, 1, 0],
            EulerOrder::Xyx => [0, 1, 0],
            EulerOrder::Xzx => [0, 2, 0],
            EulerOrder::Yxy => [1, 0, 1],
            EulerOrder::Yzy => [1, 2, 1],
            EulerOrder::Zxz => [2, 0, 2],
            EulerOrder::Zyz => [2, 1, 2],
        }
    }
}

impl EulerMap {
    /// The quaternion w, x, y, z of three angles in the map's unit: from the body's axes to the
    /// tracker's.
    pub(crate) fn quaternion(&self, angles: [f64; 3]) -> [f64; 4] {
        let about = |(axis, angle): (usize, f64)| {
            UnitQuaternion::from_axis_angle(&Vector3::ith_axis(axis), angle * self.unit.radians())
        };
        let axes = self.order.axes();
        let [first, second, third] = [0, 1, 2].map(|place| about((axes[place], angles[place])));
        rotation::parts(&match self.rotation {
            EulerRotation::Intrinsic => first * second * third,
            EulerRotation::Extrinsic => third * second * first,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::units::AngleUnit;
    use super::*;
    use nalgebra::{Quaternion, Rotation3};

    fn turned(
        order: EulerOrder,
        rotation: EulerRotation,
        angles_deg: [f64; 3],
        vector: Vector3<f64>,
    ) -> Vector3<f64> {
        let [w, x, y, z] =
            EulerMap { order, rotation, unit: AngleUnit::Deg }.quaternion(angles_deg);
        UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)) * vector
    }

    #[test]
    fn intrinsic_rotations_are_about_axes_that_turn_along() {
        use EulerRotation::{Extrinsic, Intrinsic};
        let is = |found: Vector3<f64>, wanted: Vector3<f64>| {
            assert!((found - wanted).norm() < 1e-12, "{found}")
        };
        // A quarter turn about z, then one about x or about the y axis that it was turned into.
        is(turned(EulerOrder::Zxy, Intrinsic, [90.0, 90.0, 0.0], Vector3::y()), Vector3::z());
        is(turned(EulerOrder::Zxy, Extrinsic, [90.0, 90.0, 0.0], Vector3::y()), -Vector3::x());
        is(turned(EulerOrder::Zxz, Intrinsic, [90.0, 90.0, 90.0], Vector3::x()), Vector3::z());
    }

    #[test]
    fn roll_pitch_yaw_is_both_of_its_names() {
        let [roll, pitch, yaw] = [10.0_f64, -35.0, 120.0];
        let expected =
            Rotation3::from_euler_angles(roll.to_radians(), pitch.to_radians(), yaw.to_radians());
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            let extrinsic =
                turned(EulerOrder::Xyz, EulerRotation::Extrinsic, [roll, pitch, yaw], axis);
            let intrinsic =
                turned(EulerOrder::Zyx, EulerRotation::Intrinsic, [yaw, pitch, roll], axis);
            assert!(
                (extrinsic - expected * axis).norm() < 1e-12
                    && (intrinsic - expected * axis).norm() < 1e-12
            );
        }
    }
}
