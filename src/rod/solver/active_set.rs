//! The active set: which tendons are taut.

use nalgebra::DVector;

use super::newton_state::{DerivativeUse, LuFactors, NewtonSolver};
use crate::rod::equations::boundary_conditions::TendonConstraint;
use crate::rod::equations::system::RodEquations;

/// Tendon constraints of two solves.
pub(crate) struct ConstraintChange<'a> {
    pub(crate) from: &'a [TendonConstraint],
    pub(crate) to: &'a [TendonConstraint],
}

/// Violations below this share of the solve's tolerance are ignored: the excess length of a slack
/// tendon, and the tip displacement due to a negative tension of a taut one.
const SET_TOLERANCE: f64 = 0.1;

impl NewtonSolver {
    /// Switches the tendon with the largest violation after the last step between taut and slack;
    /// true if one switched. One tendon at a time: more taut tendons than degrees of freedom of the
    /// shape would be contradictory.
    pub(super) fn change_set(
        &self,
        system: &RodEquations,
        unknowns: &mut [f64],
        taut: &mut [bool],
        constraints: &[TendonConstraint],
        step: &DVector<f64>,
        tolerance_m: f64,
    ) -> bool {
        let n = system.grid.unknowns;
        let (mut worst_tendon, mut max_violation_m) = (None, SET_TOLERANCE * tolerance_m);
        for (i, constraint) in constraints.iter().enumerate() {
            let violation_m = match constraint {
                TendonConstraint::Tension(_) => continue,
                // Tension times the tip motion per newton, so that both kinds of violation are
                // metres.
                TendonConstraint::Length(_) if taut[i] => {
                    -unknowns[n + i] * system.reach_m_per_n[i]
                }
                TendonConstraint::Length(_) => {
                    // Length after the step, to first order.
                    let shift = self.derivative.length_change_m(system, i, &step.as_slice()[..n]);
                    system.overstretch_m(i, constraint, 0.0, &self.workspace) - shift
                }
            };
            if violation_m > max_violation_m {
                (worst_tendon, max_violation_m) = (Some(i), violation_m);
            }
        }
        if let Some(i) = worst_tendon {
            taut[i] = !taut[i];
            // A tendon that changes sides starts without tension.
            unknowns[n + i] = 0.0;
        }
        worst_tendon.is_some()
    }

    /// Predicts the first residual of the next solve: the change of the tendon constraints. Valid
    /// when `unknowns` and `taut` are the solution that the current derivative has led to.
    pub(crate) fn predict_residual(
        &mut self,
        system: &RodEquations,
        unknowns: &[f64],
        taut: &[bool],
        change: &ConstraintChange,
    ) {
        let led_here = |factors: &LuFactors| factors.rate == 0.0 && factors.taut == taut;
        // Any other derivative belongs to another solution.
        if self.derivative_use != DerivativeUse::Rest
            || self.unreliable
            || !self.factors.last().is_some_and(led_here)
        {
            return;
        }
        let n = system.grid.unknowns;
        let same_kinds = change.from.iter().zip(change.to).all(|pair| match pair {
            (TendonConstraint::Length(_), TendonConstraint::Length(_)) => true,
            (before, after) => before == after,
        });
        if !same_kinds {
            return;
        }
        // At the last solution all residuals vanish but those that the new commands make.
        self.workspace.residual.fill(0.0);
        for (i, (before, after)) in
            change.from.iter().zip(change.to).enumerate().filter(|&(i, _)| taut[i])
        {
            let overstretch_m = |constraint: &TendonConstraint| {
                system.overstretch_m(i, constraint, unknowns[n + i], &self.workspace)
            };
            self.workspace.residual[n + i] = overstretch_m(after) - overstretch_m(before);
        }
        self.residual_predicted = true;
    }
}
