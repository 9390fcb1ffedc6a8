//! Error of the compliance of the sections.

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};

/// Compliance of every compressible section times `scale`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpineCompressibility {
    /// Factor on the compliance, 1 changes nothing.
    pub scale: f64,
}

pub(crate) const CARD: Card = Card {
    name: "spine_compressibility",
    missing: "different compressibility of the sections",
    equation: "c_spine → scale · c_spine (eq. 14)",
    source: "paper, eq. 14",
    parameters: &[Parameter { name: "scale", unit: "1", null: 1.0, seek: Seek::Size(0.2) }],
    usual_change: Some(0.3),
    confused_with: &["distributed_mass", "bending_stiffness"],
};

impl Effect for SpineCompressibility {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_not_negative("scale", self.scale)
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        rod.sections.iter_mut().for_each(|section| section.compliance_m_per_n *= self.scale);
    }
}
