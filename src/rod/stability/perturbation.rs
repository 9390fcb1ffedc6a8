//! The small deviation that every real rod has. A perfect one would stay on an unstable
//! equilibrium.

use nalgebra::Vector3;

use crate::rod::equations::material::{Compliance, Components};
use crate::rod::equations::system::RodEquations;
use crate::rod::state::rod::Rod;

/// Deviation in lengths of the rod that a motion gets where deviations grow.
const DEVIATION_LENGTHS: f64 = 1e-6;

impl Rod {
    /// The combination of `directions` (from [`super::tangent::Tangent::descents`]) that moves the
    /// tip towards the preferred side: +x where it can, else +y, else +z.
    pub(crate) fn preferred_direction(&self, directions: &[Vec<f64>]) -> Option<Vec<f64>> {
        let variation = &self.solver.derivative.variation;
        let last = variation.end_move.len() - 1;
        let moves: Vec<Vector3<f64>> =
            directions.iter().map(|direction| variation.end_move[last].times(direction)).collect();
        let largest = moves.iter().map(Vector3::norm).fold(0.0, f64::max);
        let reach =
            |axis: usize| moves.iter().map(|moved| moved[axis] * moved[axis]).sum::<f64>().sqrt();
        let first = directions.first()?;
        // The first axis along which the tip can go at all; rounding must not choose the side.
        let Some(axis) = (0..3).find(|&axis| reach(axis) > 1e-3 * largest) else {
            return Some(first.clone());
        };
        let mut combined = vec![0.0; first.len()];
        for (direction, moved) in directions.iter().zip(&moves) {
            combined.iter_mut().zip(direction).for_each(|(sum, x)| *sum += moved[axis] * x);
        }
        Some(combined)
    }

    /// Gives the rod at the end of the present step a velocity along `direction` where it has next
    /// to none, so that a deviation that grows with `rate` (1/s) begins with about
    /// [`DEVIATION_LENGTHS`] lengths.
    pub(crate) fn deviate(&mut self, direction: &[f64], rate: f64) {
        let Rod { system, solver, state, stages, .. } = self;
        let Some(rates) = stages.last_mut() else { return };
        let variation = &solver.derivative.variation;
        let moves: Vec<Vector3<f64>> =
            variation.node_move.iter().map(|moved| moved.times(direction)).collect();
        let largest = moves.iter().map(Vector3::norm).fold(0.0, f64::max);
        let weighted = |of: &dyn Fn(usize) -> f64| {
            moves
                .iter()
                .enumerate()
                .map(|(g, _)| system.grid.nodes[g].weight_m * of(g))
                .sum::<f64>()
        };
        let squares = weighted(&|g| moves[g].norm_squared());
        // Component of the present velocity along the direction, by mass-free projection.
        let speed = weighted(&|g| moves[g].dot(&rates.node_v[g])) / squares * largest;
        let min_speed = DEVIATION_LENGTHS * system.params.length_m() * rate;
        // A rod that moves already needs no push.
        if !(speed.abs() < min_speed && squares > 0.0) {
            return;
        }
        let share = (min_speed - speed) / largest;
        moves.iter().zip(&mut rates.node_v).for_each(|(moved, v)| *v += moved * share);
        for (k, mass) in system.masses.iter().enumerate() {
            rates.mass_v[k] += variation.end_move[mass.end].times(direction) * share;
            if mass.turns() {
                let turn = variation.end_turn[mass.end].times(direction) * share;
                rates.spin[k] += state.shape.end_r[mass.end].tr_mul(&turn);
            }
        }
        let strains = strain_changes(system, &state.shape.compliance, direction);
        for (v, strain) in rates.strain_v.iter_mut().zip(strains) {
            v.iter_mut().zip(strain).for_each(|(v, change)| *v += share * change);
        }
    }
}

/// Change of the strains at the Gauss points along a change of the coefficients.
fn strain_changes(
    system: &RodEquations,
    compliances: &[Compliance],
    direction: &[f64],
) -> Vec<Components> {
    let points = system.grid.basis.points;
    let mut field = vec![0.0; 6 * points];
    system.grid.basis.expand(direction, &mut field);
    let change = |(g, compliance): (usize, &Compliance)| {
        compliance.apply(&std::array::from_fn(|c| field[c * points + g]))
    };
    compliances.iter().enumerate().map(change).collect()
}
