//! Error of the mass along the body.

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};

/// Mass along the body, disks included, times `scale`; payloads are not scaled.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DistributedMass {
    /// Factor on every mass of the robot itself, 1 changes nothing.
    pub scale: f64,
}

pub(crate) const CARD: Card = Card {
    name: "distributed_mass",
    missing: "mass along the body",
    equation: "ρA(s) → scale · ρA(s), disks alike",
    source: "modelling convention",
    parameters: &[Parameter { name: "scale", unit: "1", null: 1.0, seek: Seek::Size(0.2) }],
    usual_change: None,
    confused_with: &["tip_load", "bending_stiffness"],
};

impl Effect for DistributedMass {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("scale", self.scale)
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        for span in &mut rod.spans {
            span.mass_kg_m *= self.scale;
            span.spread_mass_kg_m *= self.scale;
        }
        rod.masses.iter_mut().for_each(|mass| mass.mass_kg *= self.scale);
    }
}
