//! Two principal bending axes of unequal stiffness.

use serde::{Deserialize, Serialize};

use super::{Card, Effect, Parameter, Seek};
use crate::base::BadOption;
use crate::rod::RodParams;

/// Bending stiffnesses k₁, k₂ about two principal axes with the mean kept.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AnisotropicStiffness {
    /// (k₁ − k₂)/(k₁ + k₂), between −1 and 1.
    pub ratio: f64,
    /// Angle of the first principal axis from x towards y, rad.
    pub angle_rad: f64,
}

pub(super) const CARD: Card = Card {
    name: "anisotropic_stiffness",
    missing: "two principal bending axes",
    equation: "k₁ = k (1 + ratio), k₂ = k (1 − ratio)",
    source: "unsymmetric bending; the paper names the spine's triangular shape",
    parameters: &[
        Parameter { name: "ratio", unit: "1", null: 0.0, seek: Seek::Size(0.1) },
        Parameter { name: "angle_rad", unit: "rad", null: 0.0, seek: Seek::Shape(&[0.0, std::f64::consts::FRAC_PI_4]) },
    ],
    confused_with: &["tendon_angle", "bending_stiffness"],
};

impl Effect for AnisotropicStiffness {
    fn check(&self) -> Result<(), BadOption> {
        super::finite("angle_rad", self.angle_rad)?;
        if self.ratio > -1.0 && self.ratio < 1.0 {
            return Ok(());
        }
        Err(BadOption { key: "ratio", found: self.ratio.to_string(), expected: "a number between -1 and 1" })
    }

    fn alter(&self, rod: &mut RodParams) {
        for span in &mut rod.spans {
            let mean = 0.5 * (span.bending_n_m2[0] + span.bending_n_m2[1]);
            span.bending_n_m2 = [mean * (1.0 + self.ratio), mean * (1.0 - self.ratio)];
            span.principal_angle_rad = self.angle_rad;
        }
    }
}
