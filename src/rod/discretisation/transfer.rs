//! Transfer between grids of the same rod: polynomials, tensions and histories.

use super::cell::COMPONENTS;
use super::grid::Grid;
use crate::math::polynomial::legendre;
use crate::rod::params::hysteresis_law::HistoryState;

impl Grid {
    /// Projects the coefficients of the grid `from` onto the polynomials of this one; copies the
    /// tensions.
    pub(crate) fn transfer(&self, from: &Grid, source: &[f64], target: &mut [f64]) {
        target[..self.unknowns].fill(0.0);
        let mut basis = vec![0.0; from.modes.into_iter().max().unwrap_or(0)];
        for node in &self.nodes {
            let source_element = element_of(&from.elements_m, node.position_m);
            legendre(source_element.local, &mut basis);
            let element = element_of(&self.elements_m, node.position_m);
            let mut offset = source_element.index * from.modes.iter().sum::<usize>();
            for c in 0..COMPONENTS {
                let coefficients = &source[offset..offset + from.modes[c]];
                let value: f64 = coefficients.iter().zip(&basis).map(|(x, p)| x * p).sum();
                for (k, value_here) in node.basis[..self.modes[c]].iter().enumerate() {
                    // ∫ of the square of the k-th Legendre polynomial over the element.
                    let norm = element.length_m / (2 * k + 1) as f64;
                    // L² projection: orthogonality makes each coefficient an integral of its own.
                    target[node.offset[c] + k] += node.weight_m * value * value_here / norm;
                }
                offset += from.modes[c];
            }
        }
        // Tensions belong to tendons and know no grid.
        target[self.unknowns..].copy_from_slice(&source[from.unknowns..]);
    }

    /// Interpolates histories from the Gauss points of `from` to those of this grid, linearly
    /// within each cell.
    pub(crate) fn interpolate_histories(
        &self,
        from: &Grid,
        states: &[HistoryState],
    ) -> Vec<HistoryState> {
        let state = |position_m: f64| {
            let cell = from
                .boundaries_m
                .partition_point(|&end| end <= position_m)
                .clamp(1, from.cell_lengths_m.len())
                - 1;
            let [a, b] = [2 * cell, 2 * cell + 1];
            let (start, end) = (from.nodes[a].position_m, from.nodes[b].position_m);
            // Beyond the two Gauss points of a cell the line is extrapolated to its ends.
            let share = (position_m - start) / (end - start);
            std::array::from_fn(|k| states[a][k] + share * (states[b][k] - states[a][k]))
        };
        self.nodes.iter().map(|node| state(node.position_m)).collect()
    }
}

/// An element and a local coordinate (−1 to 1) in it.
struct ElementPosition {
    index: usize,
    length_m: f64,
    local: f64,
}

fn element_of(ends_m: &[f64], position_m: f64) -> ElementPosition {
    let index = ends_m.partition_point(|&end| end <= position_m).clamp(1, ends_m.len() - 1) - 1;
    let length_m = ends_m[index + 1] - ends_m[index];
    ElementPosition { index, length_m, local: 2.0 * (position_m - ends_m[index]) / length_m - 1.0 }
}
