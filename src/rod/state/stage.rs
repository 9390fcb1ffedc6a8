//! What a stage of an implicit Runge–Kutta step starts from.

use nalgebra::Vector3;

use super::rates::Rates;
use super::rod_state::RodState;
use crate::rod::equations::motion::{EndMass, Motion};

/// Rates that a stage of a step starts from: with step h, v = (p − p₀ − h Σ aᵢⱼ vⱼ)/(hγ) and
/// a = (v − v₀ − h Σ aᵢⱼ aⱼ)/(hγ).
struct History<'a> {
    rate: f64,
    /// aᵢⱼ/γ with the earlier stages' rates.
    earlier: &'a [(f64, &'a Rates)],
}

impl History<'_> {
    /// What p₀, v₀ and the earlier stages contribute to v and a of one point.
    #[inline]
    fn of(
        &self,
        p: &Vector3<f64>,
        v: &Vector3<f64>,
        stage: impl Fn(&Rates) -> (Vector3<f64>, Vector3<f64>),
    ) -> (Vector3<f64>, Vector3<f64>) {
        let (mut hist_v, mut hist_a) = (-p * self.rate, -v * self.rate);
        for (share, rates) in self.earlier {
            let (stage_v, stage_a) = stage(rates);
            hist_v -= stage_v * *share;
            hist_a -= stage_a * *share;
        }
        // a = rate · v + hist_a, and v itself holds hist_v: both in terms of the unknown p.
        (hist_v, hist_v * self.rate + hist_a)
    }
}

impl Motion {
    /// Prepares a stage of a step of `h` seconds. `row` holds the coefficients of the earlier
    /// stages, whose rates are in `stages`, and then γ.
    pub(crate) fn prepare(
        &mut self,
        start: &RodState,
        masses: &[EndMass],
        row: &[f64],
        stages: &[Rates],
        h: f64,
    ) {
        let gamma = row[row.len() - 1];
        let rate = 1.0 / (h * gamma);
        self.rate = rate;
        let earlier: Vec<(f64, &Rates)> =
            row[..row.len() - 1].iter().map(|a| a / gamma).zip(stages).collect();
        let history = History { rate, earlier: &earlier };
        let from = &start.rates;
        for (g, p) in start.shape.node_p.iter().enumerate() {
            (self.node_v[g], self.node_a[g]) =
                history.of(p, &from.node_v[g], |s| (s.node_v[g], s.node_a[g]));
            for c in 0..6 {
                let before: f64 = earlier.iter().map(|(a, s)| a * s.strain_v[g][c]).sum();
                self.strain_v[g][c] = -start.shape.strain[g][c] * rate - before;
            }
        }
        for (k, mass) in masses.iter().enumerate() {
            let p = &start.shape.end_p[mass.end];
            (self.mass_v[k], self.mass_a[k]) =
                history.of(p, &from.mass_v[k], |s| (s.mass_v[k], s.mass_a[k]));
            if mass.turns() {
                (self.spin_v[k], self.spin_a[k]) =
                    history.of(&Vector3::zeros(), &from.spin[k], |s| (s.spin[k], s.spin_a[k]));
                // Rotations do not add, so spin is measured from the orientation at the start.
                self.from_r[k] = start.shape.end_r[mass.end];
            }
        }
    }
}
