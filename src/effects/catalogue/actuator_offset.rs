//! Zero error of one tendon.

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};

/// A constant offset of one drive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ActuatorOffset {
    /// Tendon, from 1.
    pub tendon: usize,
    /// Added to its displacement, metres.
    pub offset_m: f64,
}

pub(crate) const CARD: Card = Card {
    name: "actuator_offset",
    missing: "zero offset of one tendon",
    equation: "q_i → q_i + offset",
    source: "homing error",
    parameters: &[
        Parameter { name: "tendon", unit: "number", null: 1.0, seek: Seek::Tendon },
        Parameter { name: "offset_m", unit: "m", null: 0.0, seek: Seek::Size(0.001) },
    ],
    usual_change: None,
    confused_with: &["precurvature"],
};

impl Effect for ActuatorOffset {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_counted("tendon", self.tendon)?;
        BadOption::unless_finite("offset_m", self.offset_m)
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        if let Some(tendon) = rod.tendons.get_mut(self.tendon - 1) {
            tendon.pretension_m += self.offset_m;
        }
    }

    fn tendon(&self) -> Option<usize> {
        Some(self.tendon)
    }
}
