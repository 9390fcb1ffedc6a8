//! The active set: which tendons are taut.

use nalgebra::DVector;

use super::newton_state::{DerivativeUse, LuFactors, NewtonSolver};
use crate::rod::equations::boundary_conditions::TendonConstraint;
use crate::rod::equations::system::RodEquations;

/// A tendon may be overstretched by this share of the solve's tolerance before it counts as taut, and its push may move
/// the tip by as much before it counts as slack.
const SET_TOLERANCE: f64 = 0.1;

impl NewtonSolver {
    /// Moves the tendon that offends most between taut and slack, as the step just taken says; true if one moved.
    /// One at a time: more taut tendons than the shape has freedom for would contradict each other.
    pub(super) fn change_set(
        &self,
        system: &RodEquations,
        unknowns: &mut [f64],
        (taut, holds): (&mut [bool], &[TendonConstraint]),
        step: &DVector<f64>,
        tolerance_m: f64,
    ) -> bool {
        let n = system.grid.unknowns;
        let (mut worst, mut offence) = (None, SET_TOLERANCE * tolerance_m);
        for (i, hold) in holds.iter().enumerate() {
            let own = match hold {
                TendonConstraint::Tension(_) => continue,
                TendonConstraint::Length(_) if taut[i] => -unknowns[n + i] * system.reach_m_per_n[i],
                TendonConstraint::Length(_) => {
                    // Length after the step, to first order.
                    let shift = self.derivative.length_change_m(system, i, &step.as_slice()[..n]);
                    system.overstretch_m(i, hold, 0.0, &self.workspace) - shift
                }
            };
            if own > offence {
                (worst, offence) = (Some(i), own);
            }
        }
        if let Some(i) = worst {
            taut[i] = !taut[i];
            unknowns[n + i] = 0.0;
        }
        worst.is_some()
    }

    /// Tells the next solve its first residual, which is nothing but what tendons `was` held to and `will` be, if the
    /// `unknowns` and the `taut` set are a solution that the derivative at hand has led to.
    pub(crate) fn predict_residual(
        &mut self,
        system: &RodEquations,
        (unknowns, taut): (&[f64], &[bool]),
        (was, will): (&[TendonConstraint], &[TendonConstraint]),
    ) {
        let led = |factors: &LuFactors| factors.rate == 0.0 && factors.taut == taut;
        if self.kept != DerivativeUse::Rest || self.unreliable || !self.factors.last().is_some_and(led) {
            return;
        }
        let n = system.grid.unknowns;
        let alike = was.iter().zip(will).all(|pair| match pair {
            (TendonConstraint::Length(_), TendonConstraint::Length(_)) => true,
            (before, after) => before == after,
        });
        if !alike {
            return;
        }
        self.workspace.residual.fill(0.0);
        for (i, (before, after)) in was.iter().zip(will).enumerate().filter(|&(i, _)| taut[i]) {
            let overstretch_m =
                |hold: &TendonConstraint| system.overstretch_m(i, hold, unknowns[n + i], &self.workspace);
            self.workspace.residual[n + i] = overstretch_m(after) - overstretch_m(before);
        }
        self.residual_predicted = true;
    }
}
