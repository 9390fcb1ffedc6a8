//! Dry friction in the spine: the path depends on the direction.

use std::sync::Arc;

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};
use crate::rod::{HistoryMoment, HistoryState, MomentLaw};

/// An elastoplastic moment in every cross-section.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// Moment at which a cross-section slips, N m.
    pub moment_nm: f64,
    /// Change of curvature up to slip, rad/m.
    #[serde(default = "yield_default")]
    pub yield_rad_m: f64,
    /// Whether slip about one bending axis reduces the friction about the other, as in an isotropic
    /// material. Otherwise the axes slip independently, as pairs of hinges do.
    #[serde(default)]
    pub coupled: bool,
    /// Segment, from 1 at the base; 0: the whole robot.
    #[serde(default, skip_serializing_if = "super::is_whole")]
    pub segment: usize,
}

fn yield_default() -> f64 {
    0.5
}

pub(crate) const CARD: Card = Card {
    name: "friction",
    missing: "dry friction (the path depends on the direction)",
    equation: "m_f = k (u − u_p) about each bending axis, |m_f| ≤ moment; u_p moves where it would \
               be more (k = moment / yield)",
    source: "Prandtl element with return mapping, Simo & Hughes, Computational Inelasticity, ch. 1",
    parameters: &[
        Parameter { name: "moment_nm", unit: "N m", null: 0.0, seek: Seek::Size(0.01) },
        Parameter { name: "yield_rad_m", unit: "rad/m", null: 0.5, seek: Seek::Shape(&[0.1, 0.5]) },
        Parameter { name: "coupled", unit: "flag", null: 0.0, seek: Seek::Flag },
        Parameter::SEGMENT,
    ],
    usual_change: None,
    confused_with: &["hysteresis", "backlash"],
};

impl Effect for Friction {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_not_negative("moment_nm", self.moment_nm)?;
        BadOption::unless_positive("yield_rad_m", self.yield_rad_m)
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        let stiffness_n_m2 = self.moment_nm / self.yield_rad_m;
        rod.moment_laws.push(Arc::new(Prandtl {
            moment_nm: self.moment_nm,
            stiffness_n_m2,
            coupled: self.coupled,
            range_m: rod.segment_m(self.segment),
        }));
    }

    fn segment(&self) -> Option<usize> {
        Some(self.segment)
    }
}

/// A spring of stiffness k in series with a slider; the state is the slider position u_p on both
/// axes.
#[derive(Debug)]
pub(crate) struct Prandtl {
    pub(crate) moment_nm: f64,
    pub(crate) stiffness_n_m2: f64,
    pub(crate) coupled: bool,
    /// Where it acts, metres from the base.
    pub(crate) range_m: [f64; 2],
}

/// [`Prandtl::range_m`] of a whole rod.
pub(crate) const WHOLE_ROD: [f64; 2] = [0.0, f64::INFINITY];

impl Prandtl {
    /// Trial moments with the slider fixed.
    fn trial(&self, state: &HistoryState, curvature_rad_m: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| self.stiffness_n_m2 * (curvature_rad_m[axis] - state[axis]))
    }

    /// The trial moments limited by the slip moment (return mapping).
    fn borne(&self, trial: [f64; 2]) -> [f64; 2] {
        if !self.coupled {
            return trial.map(|moment| moment.clamp(-self.moment_nm, self.moment_nm));
        }
        let size = (trial[0] * trial[0] + trial[1] * trial[1]).sqrt();
        let share = if size > self.moment_nm { self.moment_nm / size } else { 1.0 };
        trial.map(|moment| share * moment)
    }

    /// d borne / d curvature.
    fn tangent(&self, trial: [f64; 2]) -> [[f64; 2]; 2] {
        let k = self.stiffness_n_m2;
        let size = (trial[0] * trial[0] + trial[1] * trial[1]).sqrt();
        if !self.coupled {
            let [x, y] = trial.map(|moment| if moment.abs() <= self.moment_nm { k } else { 0.0 });
            return [[x, 0.0], [0.0, y]];
        }
        if size <= self.moment_nm {
            return [[k, 0.0], [0.0, k]];
        }
        // Of a radial return only the part across the direction of slip stays elastic.
        let (share, n) = (self.moment_nm / size, [trial[0] / size, trial[1] / size]);
        let entry = |a: usize, b: usize| share * k * (f64::from(u8::from(a == b)) - n[a] * n[b]);
        [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]]
    }
}

impl MomentLaw for Prandtl {
    fn acts_at(&self, position_m: f64) -> bool {
        self.range_m[0] <= position_m && position_m <= self.range_m[1]
    }

    fn moment(
        &self,
        state: &HistoryState,
        curvature_rad_m: [f64; 2],
        _bending_n_m2: f64,
    ) -> HistoryMoment {
        let trial = self.trial(state, curvature_rad_m);
        HistoryMoment { moment_nm: self.borne(trial), tangent_n_m2: self.tangent(trial) }
    }

    fn commit(
        &self,
        state: &mut HistoryState,
        curvature_rad_m: [f64; 2],
        _bending_n_m2: f64,
        _dt_s: f64,
    ) {
        let trial = self.trial(state, curvature_rad_m);
        let borne = self.borne(trial);
        for axis in 0..2 {
            // The slider follows until the spring bears no more than the slip moment.
            if borne[axis] != trial[axis] {
                state[axis] = curvature_rad_m[axis] - borne[axis] / self.stiffness_n_m2;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_closed_loop_of_curvature_dissipates_four_times_moment_times_amplitude() {
        let law =
            Prandtl { moment_nm: 0.01, stiffness_n_m2: 0.05, coupled: false, range_m: WHOLE_ROD };
        let (mut state, mut work, mut last) = ([0.0; 4], 0.0, [0.0; 2]);
        let amplitude = 3.0;
        for step in 1..=40_000 {
            let angle = f64::from(step) / 40_000.0 * 2.0 * std::f64::consts::TAU;
            let u = [amplitude * angle.sin(), 0.0];
            let moment = law.moment(&state, u, 0.0).moment_nm;
            if step > 20_000 {
                work += moment[0] * (u[0] - last[0]);
            }
            law.commit(&mut state, u, 0.0, 0.0);
            last = u;
        }
        let yielded = amplitude - 0.01 / 0.05;
        assert!((work - 4.0 * 0.01 * yielded).abs() < 1e-4 * work, "{work}");
    }
}
