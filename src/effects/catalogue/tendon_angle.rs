//! Guide holes rotated about the backbone.

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};

/// All tendons turned about the backbone by one angle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TendonAngle {
    /// Rotation from x towards y, rad.
    pub angle_rad: f64,
}

pub(crate) const CARD: Card = Card {
    name: "tendon_angle",
    missing: "rotation of the guide holes",
    equation: "r_i → R_z(angle) r_i",
    source: "geometry",
    parameters: &[Parameter { name: "angle_rad", unit: "rad", null: 0.0, seek: Seek::Size(0.04) }],
    usual_change: Some(0.05),
    confused_with: &["anisotropic_stiffness", "base_tilt"],
};

impl Effect for TendonAngle {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_finite("angle_rad", self.angle_rad)
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        rod.tendons.iter_mut().for_each(|tendon| tendon.path.turn(self.angle_rad));
    }
}
