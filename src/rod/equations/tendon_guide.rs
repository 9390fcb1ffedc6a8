//! A tendon at one Gauss point: its path and the stiffness that its tension adds.

use nalgebra::{Matrix3, Vector3};

use super::material::Components;
use crate::math::{matrix3, rotation};
use crate::rod::discretisation::cell::COMPONENTS;
use crate::rod::params::tendon::Tendon;

/// A tendon at one Gauss point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct TendonGuide {
    /// Offset from the backbone along the body axes x and y, metres.
    pub(crate) offset_m: [f64; 2],
    /// Change of that offset per length.
    pub(crate) slope: [f64; 2],
    /// Whether the tendon passes here.
    pub(crate) present: bool,
}

impl TendonGuide {
    /// Path of the tendon per length of backbone, body frame: v + u × r + r′.
    #[inline(always)]
    pub(crate) fn path(&self, s: &Components) -> Vector3<f64> {
        let ([x, y], [dx, dy]) = (self.offset_m, self.slope);
        Vector3::new(s[3] - s[2] * y + dx, s[4] + s[2] * x + dy, s[5] + s[0] * y - s[1] * x)
    }

    /// Adds tension · ∂²length/∂strain², the stiffness of a taut tendon, to `total`. Its path has
    /// the direction `t` and this `stretch`, its length per length of backbone.
    #[inline(always)]
    pub(crate) fn add_stiffness(
        &self,
        t: &Vector3<f64>,
        stretch: f64,
        tension: f64,
        total: &mut [Components; COMPONENTS],
    ) {
        let [x, y] = self.offset_m;
        // Stiffness transverse to the path, (τ/ℓ)(1 − t tᵀ), mapped to the strains: the path is v +
        // u × r.
        let across =
            Matrix3::from_fn(|i, j| (f64::from(i == j) - t[i] * t[j]) * (tension / stretch));
        let arm = rotation::skew(&Vector3::new(x, y, 0.0));
        let mixed = matrix3::product(&arm, &across);
        let turning = matrix3::product(&mixed, &arm.transpose());
        for row in 0..3 {
            for column in 0..3 {
                total[row][column] += turning[(row, column)];
                total[row][column + 3] += mixed[(row, column)];
                total[column + 3][row] += mixed[(row, column)];
                total[row + 3][column + 3] += across[(row, column)];
            }
        }
    }
}

impl Tendon {
    /// Offset and slope at `position_m`.
    pub(crate) fn guide(&self, position_m: f64) -> TendonGuide {
        let present = position_m > self.start_m && position_m <= self.end_m;
        let ([x, y], [dx, dy]) = self.path.at(position_m);
        TendonGuide { offset_m: [x, y], slope: [dx, dy], present }
    }
}
