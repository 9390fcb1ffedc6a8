//! Error estimation by a reconstructed, more accurate solution.
//!
//! The wrench of a solution is polynomial, and the balance holds in the weighted mean. The
//! reconstruction solves the balance pointwise at twice as many Gauss points, under the loads of
//! the solved shape. The remaining mean imbalance is removed with the solver's derivative. The
//! estimate thus includes the amplification of small errors in slender or nearly buckled rods.

use nalgebra::{DVector, Matrix6, Vector6};

use crate::math::vectorised;
use crate::rod::discretisation::cell::COMPONENTS;
use crate::rod::equations::boundary_conditions::{SolveConditions, TendonConstraint};
use crate::rod::equations::contact::Touch;
use crate::rod::equations::material::Components;
use crate::rod::equations::motion::Motion;
use crate::rod::equations::shape::distance_m;
use crate::rod::equations::system::{RodEquations, Workspace};
use crate::rod::state::grid_level::ConfirmedShape;
use crate::rod::state::rod::Rod;

/// Safety factor: the reconstruction is accurate to higher order; for 600 random robots it was at
/// least three quarters of the error.
const RECONSTRUCTION_SAFETY_FACTOR: f64 = 2.0;
/// Tip distance, as a share of the length, within which a confirmed shape applies; there the
/// estimate is scaled, with this safety factor.
const CONFIRMED_DISTANCE_LENGTHS: f64 = 0.05;
const CONFIRMED_SAFETY_FACTOR: f64 = 5.0;

impl Rod {
    /// Raises an estimated error below the tolerance to the error found by reconstruction. Close to
    /// a confirmed shape, scales the estimate `raw_m` instead.
    pub(crate) fn confirm_by_reconstruction(
        &mut self,
        constraints: &[TendonConstraint],
        tolerance_m: f64,
        raw_m: f64,
    ) {
        if self.grid_level.error_m > tolerance_m || tolerance_m.is_infinite() {
            return;
        }
        let tip_m = self.tip_m();
        if let Some(ConfirmedShape { tip_m: confirmed_tip_m, taut, ratio }) =
            &self.grid_level.confirmed
        {
            let near = (tip_m - confirmed_tip_m).norm()
                < CONFIRMED_DISTANCE_LENGTHS * self.system.params.length_m()
                && *taut == self.state.taut;
            if near
                && CONFIRMED_SAFETY_FACTOR * ratio * raw_m <= tolerance_m
                && self.is_stable_by_bound()
            {
                return;
            }
        }
        let apart_m = self.reconstruction_m(constraints);
        self.grid_level.error_m =
            self.grid_level.error_m.max(RECONSTRUCTION_SAFETY_FACTOR * apart_m);
        let ratio = (apart_m / raw_m.max(f64::MIN_POSITIVE)).max(1.0);
        self.grid_level.confirmed =
            Some(ConfirmedShape { tip_m, taut: self.state.taut.clone(), ratio });
    }

    /// Distance between the tips of the reconstructed and the present solution, metres, after a
    /// static solve under `constraints`. A rotation counts as angle times length. Infinite on
    /// failure.
    pub(crate) fn reconstruction_m(&mut self, constraints: &[TendonConstraint]) -> f64 {
        // 1. The same polynomials at twice as many Gauss points show the pointwise imbalance.
        let fine = self.grid_level.halved(&self.system);
        let histories: Vec<_> = self
            .state
            .histories
            .iter()
            .map(|states| fine.grid.interpolate_histories(&self.system.grid, states))
            .collect();
        // The forces of contacts stay: more points would press more on the same penetration.
        let touches: Vec<Touch> =
            self.solver.workspace.touches.iter().map(|touch| touch.on_grid(&fine.grid)).collect();
        let motion = Motion::rest(&fine.grid, &fine.masses);
        let loads = self.full_loads();
        let full = self.state.conditions(&motion, constraints, &loads, true);
        let conditions =
            SolveConditions { histories: &histories, fixed_touches: Some(&touches), ..full };
        let mut workspace = fine.workspace();
        let unknowns = &self.state.unknowns;
        fine.evaluate(unknowns, &conditions, &mut workspace);
        // 2. Balance each Gauss point by itself.
        let Some(mut wrench) = fine.local_balance(unknowns, &workspace) else {
            return f64::INFINITY;
        };
        vectorised!({
            workspace.shape.update_from(&fine.grid, &fine.sections, &wrench);
            fine.balance(unknowns, &conditions, &mut workspace);
        });
        // 3. Remove the mean imbalance that remains with the solver's derivative.
        let mut step = DVector::from_column_slice(&workspace.residual);
        if !self.solver.solve_with_last_factors(&mut step) {
            return f64::INFINITY;
        }
        let mut field = vec![0.0; COMPONENTS * fine.grid.nodes.len()];
        fine.grid.basis.expand(step.as_slice(), &mut field);
        for (g, local) in wrench.iter_mut().enumerate() {
            (0..COMPONENTS).for_each(|c| local[c] -= field[c * fine.grid.nodes.len() + g]);
        }
        vectorised!(workspace.shape.update_from(&fine.grid, &fine.sections, &wrench));
        distance_m(&self.state.shape, &workspace.shape, self.system.params.length_m())
    }
}

impl RodEquations {
    /// The wrench that balances the external one in `workspace` at each Gauss point, by one Newton
    /// iteration; its error is of higher order.
    fn local_balance(&self, unknowns: &[f64], workspace: &Workspace) -> Option<Vec<Components>> {
        let tensions = &unknowns[self.grid.unknowns..];
        let balanced = |g: usize| {
            let stiffness = self.tendon_stiffness(g, tensions, workspace);
            let mut tangent = Matrix6::from_fn(|row, column| stiffness[row][column]);
            for row in 0..2 {
                for column in 0..2 {
                    tangent[(row, column)] += workspace.history_tangent[g][row][column];
                }
            }
            let compliance = &workspace.shape.compliance[g];
            let columns: [Components; COMPONENTS] = std::array::from_fn(|c| compliance.column(c));
            let compliance = Matrix6::from_fn(|row, column| columns[column][row]);
            let matrix = Matrix6::identity() + tangent * compliance;
            let change = matrix.lu().solve(&Vector6::from_column_slice(&workspace.imbalance[g]))?;
            Some(std::array::from_fn(|c| workspace.shape.wrench[g][c] - change[c]))
        };
        (0..self.grid.nodes.len()).map(balanced).collect()
    }
}
