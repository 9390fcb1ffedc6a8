//! A constant force at the tip.

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};

/// A constant force at the tip, world frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TipForce {
    /// Force, N.
    pub force_n: [f64; 3],
}

pub(crate) const CARD: Card = Card {
    name: "tip_force",
    missing: "a constant force at the tip",
    equation: "n(L) = F",
    source: "Rucker & Webster 2011, boundary conditions",
    parameters: &[
        Parameter { name: "force_n[0]", unit: "N", null: 0.0, seek: Seek::Size(0.03) },
        Parameter { name: "force_n[1]", unit: "N", null: 0.0, seek: Seek::Size(0.03) },
        Parameter { name: "force_n[2]", unit: "N", null: 0.0, seek: Seek::Size(0.1) },
    ],
    usual_change: None,
    confused_with: &["tip_load", "base_tilt", "precurvature"],
};

impl Effect for TipForce {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_all_finite("force_n", &self.force_n)
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        rod.tip_load.force_n += nalgebra::Vector3::from(self.force_n);
    }
}
