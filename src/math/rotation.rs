//! Rotations as 3×3 matrices: exponential, logarithm, quaternions.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// The matrix of the cross product: `skew(a) * b == a × b`.
pub fn skew(a: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}

/// Rotation matrix of a rotation vector in radians (Rodrigues' formula; series below half a radian,
/// so that no trigonometric function is needed for the small steps along a rod).
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

/// Largest θ² that the series are used for.
const MAX_SERIES_ANGLE2: f64 = 0.25;

/// sin θ / θ and (1 − cos θ) / θ² as functions of θ².
fn sine_coefficients(angle2: f64) -> (f64, f64) {
    if angle2 > MAX_SERIES_ANGLE2 {
        let angle = angle2.sqrt();
        return (angle.sin() / angle, (1.0 - angle.cos()) / angle2);
    }
    sine_series(angle2)
}

/// The same as Taylor series, to rounding at half a radian, by Horner's rule.
#[inline(always)]
fn sine_series(angle2: f64) -> (f64, f64) {
    let (mut a, mut b) = (SINE[0], COSINE[0]);
    for k in 1..7 {
        a = a * angle2 + SINE[k];
        b = b * angle2 + COSINE[k];
    }
    (a, b)
}

/// ±1/(2k+1)! and ±1/(2k+2)!, from k = 6 down to 0.
const SINE: [f64; 7] = [
    1.0 / 6_227_020_800.0,
    -1.0 / 39_916_800.0,
    1.0 / 362_880.0,
    -1.0 / 5040.0,
    1.0 / 120.0,
    -1.0 / 6.0,
    1.0,
];
const COSINE: [f64; 7] = [
    1.0 / 87_178_291_200.0,
    -1.0 / 479_001_600.0,
    1.0 / 3_628_800.0,
    -1.0 / 40_320.0,
    1.0 / 720.0,
    -1.0 / 24.0,
    0.5,
];

/// A batch of rotations in structure-of-arrays form, for vector instructions.
#[derive(Clone, Debug, Default)]
pub struct Turns {
    count: usize,
    /// Rotation vectors: x of all, y of all, z of all, radians.
    vectors: Vec<f64>,
    /// Rotation matrices: entry by entry, row-major.
    matrices: Vec<f64>,
}

impl Turns {
    /// Room for `count` rotations.
    pub fn new(count: usize) -> Turns {
        Turns { count, vectors: vec![0.0; 3 * count], matrices: vec![0.0; 9 * count] }
    }

    /// Sets rotation vector `k`, radians.
    #[inline(always)]
    pub fn set(&mut self, k: usize, turn_rad: &Vector3<f64>) {
        for axis in 0..3 {
            self.vectors[axis * self.count + k] = turn_rad[axis];
        }
    }

    /// Computes all rotation matrices.
    #[inline(always)]
    pub fn exponentiate(&mut self) {
        let n = self.count;
        let (xs, yz) = self.vectors.split_at(n);
        let (ys, zs) = yz.split_at(n);
        let mut entries = self.matrices.chunks_exact_mut(n.max(1));
        // All rows have length n: without bounds checks the loop is vectorised.
        let mut next = || &mut entries.next().unwrap_or_default()[..n];
        let [m11, m12, m13] = [next(), next(), next()];
        let [m21, m22, m23] = [next(), next(), next()];
        let [m31, m32, m33] = [next(), next(), next()];
        let zs = &zs[..n];
        // A count rather than a running maximum, which would serialise the loop.
        let mut large = 0_u64;
        for k in 0..n {
            let (x, y, z) = (xs[k], ys[k], zs[k]);
            let angle2 = x * x + y * y + z * z;
            large += u64::from(angle2 > MAX_SERIES_ANGLE2);
            let (a, b) = sine_series(angle2);
            (m11[k], m12[k], m13[k]) =
                (1.0 - b * (y * y + z * z), b * x * y - a * z, b * x * z + a * y);
            (m21[k], m22[k], m23[k]) =
                (b * x * y + a * z, 1.0 - b * (x * x + z * z), b * y * z - a * x);
            (m31[k], m32[k], m33[k]) =
                (b * x * z - a * y, b * y * z + a * x, 1.0 - b * (x * x + y * y));
        }
        if large > 0 {
            self.redo_large();
        }
    }

    /// Recomputes rotations beyond half a radian with trigonometric functions.
    fn redo_large(&mut self) {
        for k in 0..self.count {
            let turn = Vector3::from_fn(|axis, _| self.vectors[axis * self.count + k]);
            if turn.norm_squared() > MAX_SERIES_ANGLE2 {
                let matrix = exp(&turn);
                for row in 0..3 {
                    for column in 0..3 {
                        self.matrices[(3 * row + column) * self.count + k] = matrix[(row, column)];
                    }
                }
            }
        }
    }

    /// Rotation matrix `k`.
    #[inline(always)]
    pub fn matrix(&self, k: usize) -> Matrix3<f64> {
        let entry = |index: usize| self.matrices[index * self.count + k];
        Matrix3::new(
            entry(0),
            entry(1),
            entry(2),
            entry(3),
            entry(4),
            entry(5),
            entry(6),
            entry(7),
            entry(8),
        )
    }
}

/// Rotation vector in radians of a rotation matrix. The angle is atan2(sin θ, cos θ), which is
/// accurate for small rotations. Near half a turn, where the antisymmetric part vanishes, nalgebra
/// is used.
pub fn log(rotation: &Matrix3<f64>) -> Vector3<f64> {
    let r = rotation;
    let axis = Vector3::new(r.m32 - r.m23, r.m13 - r.m31, r.m21 - r.m12) * 0.5;
    let (sine, cosine) = (axis.norm(), 0.5 * (r.trace() - 1.0));
    if sine < 1e-4 {
        // θ / sin θ = 1 + sin² θ / 6 to rounding here.
        return if cosine > 0.0 {
            axis * (1.0 + sine * sine / 6.0)
        } else {
            Rotation3::from_matrix_unchecked(*r).scaled_axis()
        };
    }
    axis * (sine.atan2(cosine) / sine)
}

/// Unit quaternion (w, x, y, z), w ≥ 0, of a rotation matrix.
pub fn to_quaternion(rotation: &Matrix3<f64>) -> [f64; 4] {
    parts(&UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation)))
}

/// The components (w, x, y, z) of a quaternion, with the sign for which w ≥ 0.
pub fn parts(turn: &UnitQuaternion<f64>) -> [f64; 4] {
    let sign = if turn.w < 0.0 { -1.0 } else { 1.0 };
    [turn.w, turn.i, turn.j, turn.k].map(|part| sign * part)
}

/// Interpolates between two rotations at constant rate along the shorter path. (The slerp of
/// nalgebra takes the angle from a cosine, which loses half of the digits of small rotations.)
pub fn between(
    from: &UnitQuaternion<f64>,
    to: &UnitQuaternion<f64>,
    share: f64,
) -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis((to * from.inverse()).scaled_axis() * share) * from
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponential_agrees_with_the_library_on_both_branches() {
        for v in [
            [0.0, 0.0, 0.0],
            [1e-9, 0.0, 0.0],
            [0.1, -0.3, 0.2],
            [0.29, 0.29, 0.29],
            [1.0, -2.0, 0.5],
        ] {
            let v = Vector3::from(v);
            let expected = Rotation3::new(v).into_inner();
            assert!((exp(&v) - expected).norm() < 2e-15, "{v}");
            assert!((log(&exp(&v)) - v).norm() < 1e-15 + 1e-14 * v.norm(), "{v}");
        }
    }

    #[test]
    fn a_share_of_the_way_keeps_the_digits_of_small_turns() {
        let from = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -0.8, 0.5));
        for angle_rad in [1e-9, 1e-6, 1e-3, 1.0, 3.0] {
            let way = Vector3::new(2.0, -1.0, 2.0) / 3.0 * angle_rad;
            let to = UnitQuaternion::from_scaled_axis(way) * from;
            // The same turn, written the other way.
            for to in [to, UnitQuaternion::new_unchecked(-to.into_inner())] {
                let came = (between(&from, &to, 0.25) * from.inverse()).scaled_axis();
                assert!(
                    (came - way * 0.25).norm() < 1e-15 + 1e-15 * angle_rad,
                    "{angle_rad}: {came}"
                );
            }
        }
    }

    #[test]
    fn the_parts_of_a_quaternion_are_those_with_w_not_negative() {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -0.8, 0.5));
        let other = UnitQuaternion::new_unchecked(-turn.into_inner());
        assert_eq!(parts(&turn), [turn.w, turn.i, turn.j, turn.k]);
        assert_eq!(parts(&other), parts(&turn));
        assert!(
            turn.w > 0.0 && parts(&UnitQuaternion::from_scaled_axis(Vector3::x() * 4.0))[0] > 0.0
        );
    }
}
