//! Rate-independent memory of the material.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::friction::Prandtl;
use super::{Card, Effect, Parameter, Seek};
use crate::base::BadOption;
use crate::rod::RodParams;

/// Elastoplastic elements of equal stiffness that yield one after the other: a Prandtl–Ishlinskii stress model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Hysteresis {
    /// Stiffness that all elements add together, as a share of the bending stiffness.
    pub share: f64,
    /// Curvature at which the last element yields, rad/m; the others yield at equal steps before it.
    pub range_rad_m: f64,
}

/// Number of elements: enough that the loop looks smooth against 0.5 mm of noise.
const ELEMENTS: usize = 5;

pub(super) const CARD: Card = Card {
    name: "hysteresis",
    missing: "rate-independent material memory",
    equation: "m_h = Σ_k clip(k_k (u − u_pk), ± k_k r_k), r_k = range · k / 5, k_k = share · E I / 5",
    source: "Prandtl–Ishlinskii stress model, Brokate & Sprekels, Hysteresis and Phase Transitions, ch. 2",
    parameters: &[
        Parameter { name: "share", unit: "1", null: 0.0, seek: Seek::Size(0.1) },
        Parameter { name: "range_rad_m", unit: "rad/m", null: 5.0, seek: Seek::Shape(&[2.0, 6.0]) },
    ],
    confused_with: &["friction", "backlash", "creep"],
};

impl Effect for Hysteresis {
    fn check(&self) -> Result<(), BadOption> {
        super::non_negative("share", self.share)?;
        BadOption::unless_positive("range_rad_m", self.range_rad_m)
    }

    fn alter(&self, rod: &mut RodParams) {
        let [k1, k2] = rod.spans[0].bending_n_m2;
        let stiffness_n_m2 = 0.5 * (k1 + k2) * self.share / ELEMENTS as f64;
        for element in 1..=ELEMENTS {
            let yields_at = self.range_rad_m * element as f64 / ELEMENTS as f64;
            rod.memory.push(Arc::new(Prandtl { moment_nm: stiffness_n_m2 * yields_at, stiffness_n_m2, coupled: true }));
        }
    }
}
