//! Two principal bending axes of unequal stiffness.

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};

/// Bending stiffnesses k₁, k₂ about two principal axes, with the mean unchanged. On a rod that is
/// already anisotropic, the two anisotropies add.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AnisotropicStiffness {
    /// (k₁ − k₂)/(k₁ + k₂), between −1 and 1.
    pub ratio: f64,
    /// Angle of the first principal axis from x towards y, rad.
    pub angle_rad: f64,
}

pub(crate) const CARD: Card = Card {
    name: "anisotropic_stiffness",
    missing: "different stiffness about two bending axes",
    equation: "k₁ = k (1 + ratio), k₂ = k (1 − ratio)",
    source: "unsymmetric bending; the paper names the spine's triangular shape",
    parameters: &[
        Parameter { name: "ratio", unit: "1", null: 0.0, seek: Seek::Size(0.1) },
        Parameter {
            name: "angle_rad",
            unit: "rad",
            null: 0.0,
            seek: Seek::Shape(&[0.0, std::f64::consts::FRAC_PI_4]),
        },
    ],
    usual_change: Some(0.3),
    confused_with: &["tendon_angle", "bending_stiffness"],
};

impl Effect for AnisotropicStiffness {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_finite("angle_rad", self.angle_rad)?;
        let inside = self.ratio > -1.0 && self.ratio < 1.0;
        BadOption::unless(inside, "ratio", self.ratio, "a number between -1 and 1")
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        for span in &mut rod.spans {
            let [k1, k2] = span.bending_n_m2;
            let mean = 0.5 * (k1 + k2);
            let (ratio, angle_rad) = if k1 == k2 {
                (self.ratio, self.angle_rad)
            } else {
                sum_of_anisotropies(
                    ((k1 - k2) / (k1 + k2), span.principal_angle_rad),
                    (self.ratio, self.angle_rad),
                )
            };
            span.bending_n_m2 = [mean * (1.0 + ratio), mean * (1.0 - ratio)];
            span.principal_angle_rad = angle_rad;
        }
    }
}

/// Sum of two anisotropies (ratio and angle): stiffness tensors add, and their deviatoric part
/// rotates with twice the angle of the axes.
fn sum_of_anisotropies(one: (f64, f64), other: (f64, f64)) -> (f64, f64) {
    let part = |(ratio, angle_rad): (f64, f64)| {
        nalgebra::Vector2::new((2.0 * angle_rad).cos(), (2.0 * angle_rad).sin()) * ratio
    };
    let sum = part(one) + part(other);
    (sum.norm(), 0.5 * sum.y.atan2(sum.x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn none_more_of_it_changes_nothing() {
        for (ratio, angle_rad) in [(0.3, 0.4), (0.3, -1.2), (0.05, 0.0)] {
            let (same, at) = sum_of_anisotropies((ratio, angle_rad), (0.0, 0.7));
            assert!(
                (same - ratio).abs() < 1e-12 && (at - angle_rad).abs() < 1e-12,
                "{same} at {at}"
            );
        }
        let (none, _) = sum_of_anisotropies((0.3, 0.4), (-0.3, 0.4));
        assert!(none < 1e-12, "{none}");
        let (crossed, at) = sum_of_anisotropies((0.3, 0.0), (0.1, std::f64::consts::FRAC_PI_2));
        assert!(
            (crossed - 0.2).abs() < 1e-12 && at.abs() < 1e-12,
            "axes a quarter turn apart: {crossed} at {at}"
        );
    }
}
