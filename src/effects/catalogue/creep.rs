//! Slow recovery from stress.

use std::sync::Arc;

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};
use crate::rod::{HistoryMoment, HistoryState, MomentLaw};

/// Part of the bending stiffness relaxes: a standard linear solid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Creep {
    /// Share of the instantaneous bending stiffness that relaxes, 0 to below 1.
    pub share: f64,
    /// Relaxation time, s.
    pub time_s: f64,
}

pub(crate) const CARD: Card = Card {
    name: "creep",
    missing: "slow recovery from stress (viscoelastic)",
    equation: "m = E I (u − share · u_c), u_c,t = (u − u_c) / time",
    source: "standard linear solid in Maxwell form; the paper names a long recovery time from \
             stress",
    parameters: &[
        Parameter { name: "share", unit: "1", null: 0.0, seek: Seek::Size(0.15) },
        Parameter { name: "time_s", unit: "s", null: 10.0, seek: Seek::Shape(&[0.7, 3.0, 15.0]) },
    ],
    confused_with: &["hysteresis", "damping"],
};

impl Effect for Creep {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("time_s", self.time_s)?;
        BadOption::unless_within("share", self.share, 0.0..1.0, "a number from 0 to below 1")
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        rod.moment_laws.push(Arc::new(*self));
    }
}

impl MomentLaw for Creep {
    fn moment(
        &self,
        state: &HistoryState,
        _curvature_rad_m: [f64; 2],
        bending_n_m2: f64,
    ) -> HistoryMoment {
        // The relaxed curvature changes little within a time step; the solve keeps it constant.
        let relaxed = self.share * bending_n_m2;
        HistoryMoment {
            moment_nm: [-relaxed * state[0], -relaxed * state[1]],
            tangent_n_m2: [[0.0; 2]; 2],
        }
    }

    fn settled(
        &self,
        _state: &HistoryState,
        curvature_rad_m: [f64; 2],
        bending_n_m2: f64,
    ) -> HistoryMoment {
        let relaxed = self.share * bending_n_m2;
        HistoryMoment {
            moment_nm: curvature_rad_m.map(|u| -relaxed * u),
            tangent_n_m2: [[-relaxed, 0.0], [0.0, -relaxed]],
        }
    }

    fn commit(
        &self,
        state: &mut HistoryState,
        curvature_rad_m: [f64; 2],
        _bending_n_m2: f64,
        dt_s: f64,
    ) {
        // Exact for a curvature that is constant during the step.
        let approach = 1.0 - (-dt_s / self.time_s).exp();
        for axis in 0..2 {
            state[axis] += approach * (curvature_rad_m[axis] - state[axis]);
        }
    }
}
