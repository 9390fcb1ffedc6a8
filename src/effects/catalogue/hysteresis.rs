//! Rate-independent hysteresis of the material.

use std::sync::Arc;

use super::friction::{Prandtl, WHOLE_ROD};
use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};
use crate::rod::{HistoryMoment, HistoryState, MomentLaw};

/// Elastoplastic elements of equal stiffness that yield in sequence: a Prandtl–Ishlinskii stress
/// model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Hysteresis {
    /// Total stiffness of all elements as a share of the bending stiffness.
    pub share: f64,
    /// Curvature at which the last element yields, rad/m; the others yield at equal steps before
    /// it.
    pub range_rad_m: f64,
}

/// Number of elements: enough that the loop looks smooth against 0.5 mm of noise.
const ELEMENT_COUNT: usize = 5;

pub(crate) const CARD: Card = Card {
    name: "hysteresis",
    missing: "rate-independent material memory",
    equation: "m_h = Σ_k clip(k_k (u − u_pk), ± k_k r_k), r_k = range · k / 5, k_k = share · E I / \
               5",
    source: "Prandtl–Ishlinskii stress model, Brokate & Sprekels, Hysteresis and Phase \
             Transitions, ch. 2",
    parameters: &[
        Parameter { name: "share", unit: "1", null: 0.0, seek: Seek::Size(0.1) },
        Parameter { name: "range_rad_m", unit: "rad/m", null: 5.0, seek: Seek::Shape(&[2.0, 6.0]) },
    ],
    usual_change: None,
    confused_with: &["friction", "backlash", "creep"],
};

impl Effect for Hysteresis {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_not_negative("share", self.share)?;
        BadOption::unless_positive("range_rad_m", self.range_rad_m)
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        for element in 1..=ELEMENT_COUNT {
            let yields_at_rad_m = self.range_rad_m * element as f64 / ELEMENT_COUNT as f64;
            rod.moment_laws.push(Arc::new(Element { share: self.share, yields_at_rad_m }));
        }
    }
}

/// One element; its stiffness scales with the local bending stiffness.
#[derive(Debug)]
struct Element {
    /// Share of all elements together.
    share: f64,
    yields_at_rad_m: f64,
}

impl Element {
    fn at(&self, bending_n_m2: f64) -> Prandtl {
        let stiffness_n_m2 = bending_n_m2 * self.share / ELEMENT_COUNT as f64;
        Prandtl {
            moment_nm: stiffness_n_m2 * self.yields_at_rad_m,
            stiffness_n_m2,
            coupled: true,
            range_m: WHOLE_ROD,
        }
    }
}

impl MomentLaw for Element {
    fn moment(
        &self,
        state: &HistoryState,
        curvature_rad_m: [f64; 2],
        bending_n_m2: f64,
    ) -> HistoryMoment {
        self.at(bending_n_m2).moment(state, curvature_rad_m, bending_n_m2)
    }

    fn commit(
        &self,
        state: &mut HistoryState,
        curvature_rad_m: [f64; 2],
        bending_n_m2: f64,
        dt_s: f64,
    ) {
        self.at(bending_n_m2).commit(state, curvature_rad_m, bending_n_m2, dt_s);
    }
}
