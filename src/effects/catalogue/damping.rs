//! Error of the damping.

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};

/// Viscous damping of the spine.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Damping {
    /// Bending damping over bending stiffness, s; replaces the model's.
    pub time_s: f64,
}

pub(crate) const CARD: Card = Card {
    name: "damping",
    missing: "different damping (slower or faster settling)",
    equation: "m = E I (u − u*) + E I · time · u_t",
    source: "Kelvin–Voigt; Till et al. 2019",
    parameters: &[Parameter {
        name: "time_s",
        unit: "s",
        null: 0.03,
        seek: Seek::Replaces("robot.damping_time_s", 0.05),
    }],
    usual_change: None,
    confused_with: &["delay", "creep"],
};

impl Effect for Damping {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_not_negative("time_s", self.time_s)
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        rod.damping_time_s = self.time_s;
    }
}
