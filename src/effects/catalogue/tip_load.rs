//! A mass fixed to the tip.

use nalgebra::Vector3;

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};
use crate::rod::PointMass;

/// A mass at the tip: its weight and its inertia.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TipLoad {
    /// Mass, kg.
    pub mass_kg: f64,
}

pub(crate) const CARD: Card = Card {
    name: "tip_load",
    missing: "a mass at the tip",
    equation: "F = m g at s = L, and m in the inertia there",
    source: "paper, section V-C (20 g)",
    parameters: &[Parameter { name: "mass_kg", unit: "kg", null: 0.0, seek: Seek::Size(0.005) }],
    usual_change: None,
    confused_with: &["distributed_mass", "tip_force"],
};

impl Effect for TipLoad {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_not_negative("mass_kg", self.mass_kg)
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        let position_m = rod.length_m();
        rod.masses.push(PointMass {
            position_m,
            mass_kg: self.mass_kg,
            inertia_kg_m2: Vector3::zeros(),
        });
    }

    fn is_payload(&self) -> bool {
        true
    }
}
