//! Variation of the shape with the unknowns: δθ(s) = ∫ R δu and δp(s) = ∫ R δv + δθ × R v in the
//! world frame, with the quadrature of the shape itself.

use super::shape::Shape;
use super::world_vectors::VectorDerivative;
use crate::math::matrix3;
use crate::rod::discretisation::cell::COMPONENTS;
use crate::rod::discretisation::grid::Grid;

/// Derivatives of orientation (as a world rotation vector) and position along the rod.
#[derive(Clone, Debug)]
pub(crate) struct ShapeVariation {
    /// At the Gauss points.
    pub(crate) node_turn: Vec<VectorDerivative>,
    pub(crate) node_move: Vec<VectorDerivative>,
    /// At the cell ends.
    pub(crate) end_turn: Vec<VectorDerivative>,
    pub(crate) end_move: Vec<VectorDerivative>,
    /// World strain rates R A φ at the two Gauss points of a cell: curvature and stretch.
    turn_rate: [VectorDerivative; 2],
    move_rate: [VectorDerivative; 2],
}

impl ShapeVariation {
    pub(crate) fn new(grid: &Grid) -> ShapeVariation {
        let zero = VectorDerivative::zeros(grid.unknowns);
        ShapeVariation {
            node_turn: vec![zero.clone(); grid.nodes.len()],
            node_move: vec![zero.clone(); grid.nodes.len()],
            end_turn: vec![zero.clone(); grid.boundaries_m.len()],
            end_move: vec![zero.clone(); grid.boundaries_m.len()],
            turn_rate: [zero.clone(), zero.clone()],
            move_rate: [zero.clone(), zero],
        }
    }

    /// Computes the variations of `shape`; the base does not move.
    #[inline(always)]
    pub(crate) fn update(&mut self, grid: &Grid, shape: &Shape) {
        for (c, &cell_m) in grid.cell_lengths_m.iter().enumerate() {
            let half = 0.5 * cell_m;
            let partial = Grid::partial_weights(cell_m);
            for row in 0..2 {
                let (turn, moved) = (&mut self.turn_rate[row], &mut self.move_rate[row]);
                // Both Gauss points first: each partial sum needs the rates of both.
                strain_rates(grid, shape, 2 * c + row, turn, moved);
            }
            for row in 0..2 {
                // Turns first: the stretch of a Gauss point turns with it.
                let g = 2 * c + row;
                let weights = partial[row];
                let rates = [(&self.turn_rate[0], weights[0]), (&self.turn_rate[1], weights[1])];
                self.node_turn[g].set_sum(&self.end_turn[c], rates[0], rates[1]);
                let tangent = matrix3::times(&shape.node_r[g], &shape.strain[g][3..]);
                self.move_rate[row].add_cross(&self.node_turn[g], &tangent, 1.0);
            }
            for row in 0..2 {
                let weights = partial[row];
                let rates = [(&self.move_rate[0], weights[0]), (&self.move_rate[1], weights[1])];
                self.node_move[2 * c + row].set_sum(&self.end_move[c], rates[0], rates[1]);
            }
            let (before, after) = self.end_turn.split_at_mut(c + 1);
            after[0].set_sum(&before[c], (&self.turn_rate[0], half), (&self.turn_rate[1], half));
            let (before, after) = self.end_move.split_at_mut(c + 1);
            after[0].set_sum(&before[c], (&self.move_rate[0], half), (&self.move_rate[1], half));
        }
    }
}

/// World-frame strain variations at Gauss point `g`: R A φ for curvature (turn) and stretch (move).
#[inline(always)]
fn strain_rates(
    grid: &Grid,
    shape: &Shape,
    g: usize,
    turn: &mut VectorDerivative,
    moved: &mut VectorDerivative,
) {
    turn.fill_zero();
    moved.fill_zero();
    let node = &grid.nodes[g];
    for component in 0..COMPONENTS {
        let strain = shape.compliance[g].column(component);
        let columns = node.offset[component]..node.offset[component] + grid.modes[component];
        let (target, part) =
            if component < 3 { (&mut *turn, &strain[..3]) } else { (&mut *moved, &strain[3..]) };
        let world = matrix3::times(&shape.node_r[g], part);
        for (row, factor) in target.rows_mut().into_iter().zip(world.iter()) {
            for (slot, basis) in row[columns.clone()].iter_mut().zip(&node.basis) {
                *slot = factor * basis;
            }
        }
    }
}
