//! Tendons are elastic.

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};

/// Every tendon stretches with its tension.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TendonStretch {
    /// Stretch of a whole tendon per tension, m/N.
    pub compliance_m_per_n: f64,
}

pub(crate) const CARD: Card = Card {
    name: "tendon_stretch",
    missing: "elasticity of the tendons",
    equation: "length + pull = L + C τ",
    source: "Till et al. 2019; Oliver-Butler et al. 2019",
    parameters: &[Parameter {
        name: "compliance_m_per_n",
        unit: "m/N",
        null: 0.0,
        seek: Seek::Size(1e-4),
    }],
    usual_change: None,
    confused_with: &["actuator_gain", "soft_section"],
};

impl Effect for TendonStretch {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_not_negative("compliance_m_per_n", self.compliance_m_per_n)
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        rod.tendons
            .iter_mut()
            .for_each(|tendon| tendon.compliance_m_per_n += self.compliance_m_per_n);
    }
}
