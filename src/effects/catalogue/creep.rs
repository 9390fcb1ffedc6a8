//! Slow recovery from stress.

use std::sync::Arc;

use crate::base::is_default;
use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};
use crate::rod::{HistoryMoment, HistoryState, MomentLaw};

/// Part of the bending stiffness relaxes: a standard linear solid. The model's stiffness is the
/// instantaneous one or, if `relaxed`, the relaxed one: one law in two conventions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Creep {
    /// Share of the instantaneous bending stiffness that relaxes, 0 to below 1.
    pub share: f64,
    /// Relaxation time, s.
    pub time_s: f64,
    /// Whether the model's bending stiffness is the relaxed one.
    #[serde(default, skip_serializing_if = "is_default")]
    pub relaxed: bool,
}

pub(crate) const CARD: Card = Card {
    name: "creep",
    missing: "slow recovery from stress (viscoelastic)",
    equation: "m = E I (u − share · u_c), u_c,t = (u − u_c) / time; relaxed: E I / (1 − share) in \
               place of E I",
    source: "standard linear solid in Maxwell form; the paper names a long recovery time from \
             stress",
    parameters: &[
        Parameter { name: "share", unit: "1", null: 0.0, seek: Seek::Size(0.15) },
        Parameter { name: "time_s", unit: "s", null: 10.0, seek: Seek::Shape(&[0.7, 3.0, 15.0]) },
        Parameter { name: "relaxed", unit: "flag", null: 0.0, seek: Seek::Convention },
    ],
    usual_change: Some(0.3),
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

impl Creep {
    /// Share of the way to the curvature of a rest that the relaxed curvature goes in `dt_s`.
    fn approach(&self, dt_s: f64) -> f64 {
        1.0 - (-dt_s / self.time_s).exp()
    }

    /// Moment at this curvature, whose relaxed part has come `approach` nearer to it.
    fn after(
        &self,
        state: &HistoryState,
        curvature_rad_m: [f64; 2],
        bending_n_m2: f64,
        approach: f64,
    ) -> HistoryMoment {
        let relaxing =
            self.share * bending_n_m2 / if self.relaxed { 1.0 - self.share } else { 1.0 };
        // What is stiffer at once than the model by as much as relaxes.
        let added = if self.relaxed { relaxing } else { 0.0 };
        let tangent = added - relaxing * approach;
        HistoryMoment {
            moment_nm: std::array::from_fn(|axis| {
                tangent * curvature_rad_m[axis] - relaxing * (1.0 - approach) * state[axis]
            }),
            tangent_n_m2: [[tangent, 0.0], [0.0, tangent]],
        }
    }
}

impl MomentLaw for Creep {
    fn moment(
        &self,
        state: &HistoryState,
        curvature_rad_m: [f64; 2],
        bending_n_m2: f64,
    ) -> HistoryMoment {
        // The relaxed curvature changes little within a time step; the solve keeps it constant.
        self.after(state, curvature_rad_m, bending_n_m2, 0.0)
    }

    fn settled(
        &self,
        state: &HistoryState,
        curvature_rad_m: [f64; 2],
        bending_n_m2: f64,
        rested_s: f64,
    ) -> HistoryMoment {
        self.after(state, curvature_rad_m, bending_n_m2, self.approach(rested_s))
    }

    fn commit(
        &self,
        state: &mut HistoryState,
        curvature_rad_m: [f64; 2],
        _bending_n_m2: f64,
        dt_s: f64,
    ) {
        // Exact for a curvature that is constant during the step.
        let approach = self.approach(dt_s);
        for axis in 0..2 {
            state[axis] += approach * (curvature_rad_m[axis] - state[axis]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Rows;
    use crate::effects::{EffectSpec, Model, Starts, Trial, replay};

    const SHARE: f64 = 0.3;

    fn creep(relaxed: bool) -> Creep {
        Creep { share: SHARE, time_s: 5.0, relaxed }
    }

    #[test]
    fn both_conventions_are_one_law() {
        // Both with the elastic moment of the model's stiffness: 0.03 N m² at once.
        let total = |law: Creep, model_n_m2: f64, rested_s: f64| {
            let mut state = [0.5, -0.2, 0.0, 0.0];
            let u = [0.8, 0.3];
            let settled = law.settled(&state, u, model_n_m2, rested_s).moment_nm;
            law.commit(&mut state, u, model_n_m2, rested_s);
            let then = law.moment(&state, u, model_n_m2).moment_nm;
            [settled, then].map(|moment| moment[0] + model_n_m2 * u[0])
        };
        for rested_s in [0.0, 2.0, f64::INFINITY] {
            let at_once = total(creep(false), 0.03, rested_s);
            let after = total(creep(true), 0.03 * (1.0 - SHARE), rested_s);
            assert!((at_once[0] - at_once[1]).abs() < 1e-15, "a rest ends where motion goes on");
            assert!((at_once[0] - after[0]).abs() < 1e-15, "{at_once:?} {after:?}");
        }
    }

    /// First and last height of a tip that hangs at home for 2 s.
    fn heights_m(rested_s: Option<f64>, starts: Starts) -> [f64; 2] {
        let mut model =
            Model { effects: vec![EffectSpec::Creep(creep(false))], ..Model::default() };
        model.tracking.rested_s = rested_s;
        let mut commands = Rows::new(4);
        (0..4).for_each(|_| commands.push(&[0.0; 4]));
        let trial = Trial {
            commands: &commands,
            durations_s: &[0.5; 4],
            tensions: false,
            at_rest: false,
            starts,
            tip_loads: None,
        };
        let tips_m = replay(&model, &[], &trial, &[]).unwrap().tips_m;
        [tips_m[0][0], tips_m[4][0]]
    }

    #[test]
    fn a_robot_that_has_rested_shortly_goes_on_sinking() {
        let [first, last] = heights_m(None, Starts::Home);
        assert!((first - last).abs() < 1e-5, "relaxed: {first} to {last}");
        let [fresh, after_2_s] = heights_m(Some(0.0), Starts::Home);
        assert!(
            first < after_2_s - 1e-4 && after_2_s < fresh - 1e-4,
            "{first} {after_2_s} {fresh}"
        );
        // The curvature counts as constant while the robot rests.
        let [rested_2_s, _] = heights_m(Some(2.0), Starts::Home);
        assert!((rested_2_s - after_2_s).abs() < 0.1 * (fresh - first), "{rested_2_s} {after_2_s}");
        assert!((heights_m(Some(1e3), Starts::Home)[0] - first).abs() < 1e-6);
        // Away from home a trial begins at rest for good.
        assert_eq!(heights_m(Some(0.0), Starts::Anywhere), heights_m(None, Starts::Anywhere));
    }
}
