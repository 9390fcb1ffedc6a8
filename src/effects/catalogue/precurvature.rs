//! Not straight when unloaded.

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};

/// A constant curvature of the unloaded rod.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Precurvature {
    /// Curvature about body x, rad/m (positive bends towards −y).
    pub kappa_x_rad_m: f64,
    /// Curvature about body y, rad/m (positive bends towards +x).
    pub kappa_y_rad_m: f64,
}

pub(crate) const CARD: Card = Card {
    name: "precurvature",
    missing: "curvature without load",
    equation: "u* = (κ_x, κ_y, 0)",
    source: "Rucker & Webster 2011, reference curvature",
    parameters: &[
        Parameter { name: "kappa_x_rad_m", unit: "rad/m", null: 0.0, seek: Seek::Size(0.2) },
        Parameter { name: "kappa_y_rad_m", unit: "rad/m", null: 0.0, seek: Seek::Size(0.2) },
    ],
    usual_change: None,
    confused_with: &["tip_force", "base_tilt", "actuator_offset"],
};

impl Effect for Precurvature {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_finite("kappa_x_rad_m", self.kappa_x_rad_m)?;
        BadOption::unless_finite("kappa_y_rad_m", self.kappa_y_rad_m)
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        let added = nalgebra::Vector3::new(self.kappa_x_rad_m, self.kappa_y_rad_m, 0.0);
        rod.spans.iter_mut().for_each(|span| span.rest_curvature_rad_m += added);
    }
}
