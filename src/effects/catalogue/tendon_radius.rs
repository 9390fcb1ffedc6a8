//! Error of the radius of the guide holes.

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};

/// Distance of all tendons from the backbone times `scale`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TendonRadius {
    /// Factor on the distance, 1 changes nothing.
    pub scale: f64,
}

pub(crate) const CARD: Card = Card {
    name: "tendon_radius",
    missing: "different radius of the guide holes",
    equation: "r_i → scale · r_i",
    source: "geometry",
    parameters: &[Parameter { name: "scale", unit: "1", null: 1.0, seek: Seek::Size(0.04) }],
    usual_change: Some(0.05),
    confused_with: &["actuator_gain", "soft_section"],
};

impl Effect for TendonRadius {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("scale", self.scale)
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        rod.tendons.iter_mut().for_each(|tendon| tendon.path.scale(self.scale));
    }
}
