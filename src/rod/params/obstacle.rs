//! Fixed obstacles that a rod cannot enter.

use nalgebra::{Matrix3, Vector3};

/// A fixed obstacle.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// Its shape and place, world frame.
    pub shape: ObstacleShape,
    /// Coefficient of Coulomb friction.
    pub friction_coefficient: f64,
    /// Force per penetration at each point of contact, N/m; `None`: rigid.
    pub stiffness_n_m: Option<f64>,
}

/// Shape and place of an obstacle, world frame, metres.
#[derive(Clone, Debug, PartialEq)]
pub enum ObstacleShape {
    /// All points p with `normal`·p ≤ `offset_m`; the unit normal points out of the obstacle.
    HalfSpace {
        /// Unit vector.
        normal: Vector3<f64>,
        /// Distance of the plane from the origin along the normal.
        offset_m: f64,
    },
    /// A ball.
    Sphere {
        /// Its centre.
        center_m: Vector3<f64>,
        /// Its radius.
        radius_m: f64,
    },
    /// A round cylinder with flat ends; infinite where the length is.
    Cylinder {
        /// Middle of its axis.
        center_m: Vector3<f64>,
        /// Unit vector along its axis.
        axis: Vector3<f64>,
        /// Its radius.
        radius_m: f64,
        /// Its length.
        length_m: f64,
    },
    /// All points within a radius of a line segment.
    Capsule {
        /// The ends of the segment.
        ends_m: [Vector3<f64>; 2],
        /// The radius.
        radius_m: f64,
    },
}

/// The surface of an obstacle as seen from a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Distance of the place from the surface, metres; negative inside.
    pub distance_m: f64,
    /// Unit normal, towards the outside.
    pub normal: Vector3<f64>,
    /// Derivative of the normal with respect to the place, 1/m.
    pub curvature_1_m: Matrix3<f64>,
}

impl ObstacleShape {
    /// Half of its thickness, metres; infinite for a half space.
    pub(crate) fn radius_m(&self) -> f64 {
        match self {
            ObstacleShape::HalfSpace { .. } => f64::INFINITY,
            ObstacleShape::Sphere { radius_m, .. } | ObstacleShape::Capsule { radius_m, .. } => {
                *radius_m
            }
            ObstacleShape::Cylinder { radius_m, length_m, .. } => radius_m.min(0.5 * length_m),
        }
    }

    /// The surface as seen from `place_m`.
    pub fn surface(&self, place_m: &Vector3<f64>) -> Surface {
        match self {
            ObstacleShape::HalfSpace { normal, offset_m } => {
                let distance_m = normal.dot(place_m) - offset_m;
                Surface { distance_m, normal: *normal, curvature_1_m: Matrix3::zeros() }
            }
            ObstacleShape::Sphere { center_m, radius_m } => {
                around(&(place_m - center_m), *radius_m, None)
            }
            ObstacleShape::Cylinder { center_m, axis, radius_m, length_m } => {
                cylinder(&(place_m - center_m), axis, *radius_m, 0.5 * length_m)
            }
            ObstacleShape::Capsule { ends_m: [start, end], radius_m } => {
                let (segment, from_start) = (end - start, place_m - start);
                let share =
                    from_start.dot(&segment) / segment.norm_squared().max(f64::MIN_POSITIVE);
                let inside = (0.0..=1.0).contains(&share);
                let axis = inside.then(|| segment.normalize());
                around(&(from_start - segment * share.clamp(0.0, 1.0)), *radius_m, axis)
            }
        }
    }
}

/// The surface at `radius_m` from the origin, or from the line along `axis` through it, seen from
/// `arm`.
fn around(arm: &Vector3<f64>, radius_m: f64, axis: Option<Vector3<f64>>) -> Surface {
    let from_center_m = arm.norm();
    // From the very middle every direction is as good.
    let normal = if from_center_m > 0.0 { arm / from_center_m } else { any_normal_to(axis) };
    let across = Matrix3::identity() - normal * normal.transpose();
    let across = axis.map_or(across, |axis| across - axis * axis.transpose());
    // Towards the middle the curvature would grow without bound.
    Surface {
        distance_m: from_center_m - radius_m,
        normal,
        curvature_1_m: across / from_center_m.max(radius_m * 1e-3),
    }
}

fn any_normal_to(axis: Option<Vector3<f64>>) -> Vector3<f64> {
    let Some(axis) = axis else { return Vector3::x() };
    // A reference that is not parallel to the axis, so that the cross product keeps its digits.
    let reference = if axis.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    axis.cross(&reference).normalize()
}

/// The surface of a cylinder about the origin: its side, a flat end, or the rim between them.
fn cylinder(arm: &Vector3<f64>, axis: &Vector3<f64>, radius_m: f64, half_length_m: f64) -> Surface {
    let along_m = arm.dot(axis);
    let across = arm - axis * along_m;
    let side = around(&across, radius_m, Some(*axis));
    let past_end_m = along_m.abs() - half_length_m;
    let outwards = axis * along_m.signum();
    // Nearest point on the rim. The normal turns about the rim in the plane of the axis, and about
    // the axis along the rim.
    if past_end_m > 0.0 && side.distance_m > 0.0 {
        let from_rim = side.normal * side.distance_m + outwards * past_end_m;
        let distance_m = from_rim.norm();
        let normal = from_rim / distance_m;
        let tangent = side.normal.cross(axis);
        let about_rim =
            Matrix3::identity() - normal * normal.transpose() - tangent * tangent.transpose();
        let about_axis = tangent * tangent.transpose() * (normal.dot(&side.normal) / across.norm());
        return Surface { distance_m, normal, curvature_1_m: about_rim / distance_m + about_axis };
    }
    if past_end_m > side.distance_m {
        return Surface {
            distance_m: past_end_m,
            normal: outwards,
            curvature_1_m: Matrix3::zeros(),
        };
    }
    side
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_and_curvatures_are_derivatives_of_the_distance() {
        let axis = Vector3::new(1.0, 2.0, -0.5).normalize();
        let (center_m, radius_m) = (Vector3::new(0.1, -0.2, 0.3), 0.05);
        let shapes = [
            ObstacleShape::HalfSpace { normal: axis, offset_m: 0.02 },
            ObstacleShape::Sphere { center_m, radius_m },
            ObstacleShape::Cylinder { center_m, axis, radius_m, length_m: 0.1 },
            ObstacleShape::Cylinder { center_m, axis, radius_m, length_m: f64::INFINITY },
            ObstacleShape::Capsule { ends_m: [center_m, center_m + axis * 0.1], radius_m },
        ];
        let places = [
            [0.2, -0.1, 0.35],
            [0.14, -0.22, 0.28],
            [0.3, 0.2, 0.1],
            [0.05, -0.35, 0.33],
            [0.17, -0.04, 0.2],
        ];
        for shape in &shapes {
            for place in places.map(Vector3::from) {
                let here = shape.surface(&place);
                for axis in 0..3 {
                    let mut step = Vector3::zeros();
                    step[axis] = 1e-6;
                    let (after, before) =
                        (shape.surface(&(place + step)), shape.surface(&(place - step)));
                    let slope = (after.distance_m - before.distance_m) / 2e-6;
                    assert!((slope - here.normal[axis]).abs() < 1e-6, "{shape:?} {place}");
                    let turn = (after.normal - before.normal) / 2e-6;
                    assert!(
                        (turn - here.curvature_1_m.column(axis)).norm() < 1e-4,
                        "{shape:?} {place}"
                    );
                }
            }
        }
    }
}
