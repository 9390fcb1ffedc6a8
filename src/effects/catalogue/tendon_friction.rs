//! Friction of the tendons in their guides.

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};
use crate::rod::PRESLIDING_M;

/// Friction of every tendon in its guides: its tension decreases along the path in the direction of
/// sliding.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TendonFriction {
    /// Coefficient of friction μ between tendon and guides.
    pub coefficient: f64,
    /// Displacement of the drive that fully mobilises the friction, metres.
    #[serde(default = "presliding_default")]
    pub presliding_m: f64,
}

fn presliding_default() -> f64 {
    PRESLIDING_M
}

pub(crate) const CARD: Card = Card {
    name: "tendon_friction",
    missing: "friction of tendons in their guides",
    equation: "τ(s) = τ(0) exp(−μ σ Θ(s)), Θ the turn of the path; σ follows the drive by dσ = \
               dq/presliding, |σ| ≤ 1",
    source: "capstan equation; Kato et al. 2015 (tendon-driven continuum robots), presliding of \
             Dahl 1968",
    parameters: &[
        Parameter { name: "coefficient", unit: "1", null: 0.0, seek: Seek::Size(0.05) },
        Parameter {
            name: "presliding_m",
            unit: "m",
            null: PRESLIDING_M,
            seek: Seek::Shape(&[PRESLIDING_M]),
        },
    ],
    usual_change: None,
    confused_with: &["friction", "hysteresis", "backlash"],
};

impl Effect for TendonFriction {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_not_negative("coefficient", self.coefficient)?;
        BadOption::unless_positive("presliding_m", self.presliding_m)
    }

    fn has_memory_at_rest(&self) -> bool {
        true
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        for tendon in &mut rod.tendons {
            tendon.friction_coefficient += self.coefficient;
            tendon.presliding_m = self.presliding_m;
        }
    }
}
