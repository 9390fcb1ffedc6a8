//! Scale error of one lead screw.

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, Seek, Serialize};

/// One drive moves a multiple of its command.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ActuatorGain {
    /// Tendon, from 1.
    pub tendon: usize,
    /// Factor, 1 changes nothing.
    pub scale: f64,
}

pub(crate) const CARD: Card = Card {
    name: "actuator_gain",
    missing: "scale error of one lead screw",
    equation: "q_i → scale · q_i",
    source: "steps per millimetre",
    parameters: &[
        Parameter { name: "tendon", unit: "number", null: 1.0, seek: Seek::Tendon },
        Parameter { name: "scale", unit: "1", null: 1.0, seek: Seek::Size(0.04) },
    ],
    usual_change: None,
    confused_with: &["tendon_radius", "tendon_stretch"],
};

impl Effect for ActuatorGain {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_counted("tendon", self.tendon)?;
        BadOption::unless_positive("scale", self.scale)
    }

    fn modify_command(&mut self, pulls_m: &mut [f64], _dt_s: f64) {
        if let Some(pull) = pulls_m.get_mut(self.tendon - 1) {
            *pull *= self.scale;
        }
    }

    fn tendon(&self) -> Option<usize> {
        Some(self.tendon)
    }
}
