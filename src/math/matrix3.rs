//! Unrolled products of 3×3 matrices and vectors: several times faster than the general product of
//! nalgebra.

use nalgebra::{Matrix3, Vector3};

/// a b.
#[inline(always)]
pub fn product(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Matrix3<f64> {
    let entry =
        |i: usize, j: usize| a[(i, 0)] * b[(0, j)] + a[(i, 1)] * b[(1, j)] + a[(i, 2)] * b[(2, j)];
    Matrix3::new(
        entry(0, 0),
        entry(0, 1),
        entry(0, 2),
        entry(1, 0),
        entry(1, 1),
        entry(1, 2),
        entry(2, 0),
        entry(2, 1),
        entry(2, 2),
    )
}

/// a x.
#[inline(always)]
pub fn times(a: &Matrix3<f64>, x: &[f64]) -> Vector3<f64> {
    let entry = |i: usize| a[(i, 0)] * x[0] + a[(i, 1)] * x[1] + a[(i, 2)] * x[2];
    Vector3::new(entry(0), entry(1), entry(2))
}

/// aᵀ x.
#[inline(always)]
pub fn transpose_times(a: &Matrix3<f64>, x: &Vector3<f64>) -> Vector3<f64> {
    let entry = |j: usize| a[(0, j)] * x.x + a[(1, j)] * x.y + a[(2, j)] * x.z;
    Vector3::new(entry(0), entry(1), entry(2))
}
