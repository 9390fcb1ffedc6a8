//! Rotations as 3×3 matrices: exponential, logarithm, quaternions.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// The matrix of the cross product: `skew(a) * b == a × b`.
pub fn skew(a: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}

/// Rotation matrix of a rotation vector in radians (Rodrigues' formula; series below half a radian, so that no
/// trigonometric function is needed for the small steps along a rod).
pub fn exp(rotation_rad: &Vector3<f64>) -> Matrix3<f64> {
    let angle2 = rotation_rad.norm_squared();
    let (a, b) = sine_coefficients(angle2);
    let (x, y, z) = (rotation_rad.x, rotation_rad.y, rotation_rad.z);
    Matrix3::new(
        1.0 - b * (y * y + z * z),
        b * x * y - a * z,
        b * x * z + a * y,
        b * x * y + a * z,
        1.0 - b * (x * x + z * z),
        b * y * z - a * x,
        b * x * z - a * y,
        b * y * z + a * x,
        1.0 - b * (x * x + y * y),
    )
}

/// sin θ / θ and (1 − cos θ) / θ² as functions of θ².
fn sine_coefficients(angle2: f64) -> (f64, f64) {
    if angle2 > 0.25 {
        let angle = angle2.sqrt();
        return (angle.sin() / angle, (1.0 - angle.cos()) / angle2);
    }
    // Taylor series to rounding at half a radian, by Horner's rule.
    let (mut a, mut b) = (1.0, 1.0);
    for k in (0..7).rev() {
        a = 1.0 - angle2 * SINE_RATIOS[k] * a;
        b = 1.0 - angle2 * COSINE_RATIOS[k] * b;
    }
    (a, 0.5 * b)
}

/// 1/((2k)(2k+1)) and 1/((2k+1)(2k+2)), the ratios of successive terms, from k = 1.
const SINE_RATIOS: [f64; 7] = [1.0 / 6.0, 1.0 / 20.0, 1.0 / 42.0, 1.0 / 72.0, 1.0 / 110.0, 1.0 / 156.0, 1.0 / 210.0];
const COSINE_RATIOS: [f64; 7] = [1.0 / 12.0, 1.0 / 30.0, 1.0 / 56.0, 1.0 / 90.0, 1.0 / 132.0, 1.0 / 182.0, 1.0 / 240.0];

/// Rotation vector in radians of a rotation matrix (by way of a quaternion: the arc cosine of a trace loses angles below
/// 1e-8).
pub fn log(rotation: &Matrix3<f64>) -> Vector3<f64> {
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation)).scaled_axis()
}

/// Unit quaternion (w, x, y, z), w ≥ 0, of a rotation matrix.
pub fn to_quaternion(rotation: &Matrix3<f64>) -> [f64; 4] {
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation));
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    [sign * q.w, sign * q.i, sign * q.j, sign * q.k]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponential_agrees_with_the_library_on_both_branches() {
        for v in [[0.0, 0.0, 0.0], [1e-9, 0.0, 0.0], [0.1, -0.3, 0.2], [0.29, 0.29, 0.29], [1.0, -2.0, 0.5]] {
            let v = Vector3::from(v);
            let expected = Rotation3::new(v).into_inner();
            assert!((exp(&v) - expected).norm() < 2e-15, "{v}");
            assert!((log(&exp(&v)) - v).norm() < 1e-12, "{v}");
        }
    }
}
