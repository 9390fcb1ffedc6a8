//! Rate-dependent part of the derivative: viscosity D and inertia M, added as rate·D + rate²·M.

use nalgebra::{Matrix3, Vector3};

use super::boundary_conditions::SolveConditions;
use super::system::{RodEquations, Workspace};
use super::variation::ShapeVariation;
use super::world_vectors::{VectorDerivative, padded};
use crate::rod::discretisation::basis::dot;

/// D and M over the polynomial coefficients, row-major.
#[derive(Clone, Debug)]
pub(crate) struct RateMatrices {
    viscosity: Vec<f64>,
    inertia: Vec<f64>,
    /// Room for a field over the Gauss points, and for the displacements of all masses by unknown.
    field: Vec<f64>,
    gathered: Vec<f64>,
}

impl RateMatrices {
    pub(crate) fn new(system: &RodEquations) -> RateMatrices {
        let (n, points) = (system.grid.unknowns, system.grid.nodes.len());
        RateMatrices {
            viscosity: vec![0.0; n * n],
            inertia: vec![0.0; n * n],
            field: vec![0.0; points],
            gathered: vec![0.0; n * padded(3 * (points + system.masses.len()))],
        }
    }

    /// Computes both for the shape in `workspace`, whose displacements are in `variation`.
    #[inline(always)]
    pub(crate) fn update(
        &mut self,
        system: &RodEquations,
        conditions: &SolveConditions,
        workspace: &Workspace,
        variation: &ShapeVariation,
    ) {
        self.add_viscosity(system, workspace);
        self.add_drag(system, conditions, workspace, variation);
        self.add_inertia(system, workspace, variation);
    }

    /// Row `row` of D and M together.
    pub(crate) fn row(&self, row: usize) -> impl Iterator<Item = (&f64, &f64)> {
        let n = self.inertia.len().isqrt();
        self.viscosity[row * n..][..n].iter().zip(&self.inertia[row * n..][..n])
    }

    /// D: viscous wrenches are local and diagonal in the strains; only bending about the two axes
    /// is coupled.
    #[inline(always)]
    fn add_viscosity(&mut self, system: &RodEquations, workspace: &Workspace) {
        self.viscosity.fill(0.0);
        // Both off-diagonal bending entries count: principal axes may be turned.
        const PAIRS: [(usize, usize); 8] =
            [(0, 0), (0, 1), (1, 0), (1, 1), (2, 2), (3, 3), (4, 4), (5, 5)];
        for (row, column) in PAIRS {
            for (g, node) in system.grid.nodes.iter().enumerate() {
                let strain = workspace.shape.compliance[g].column(column);
                let viscous = std::array::from_fn(|c| system.sections[g].viscosity[c] * strain[c]);
                self.field[g] = node.weight_m * workspace.weighted_strain(g, &viscous)[row];
            }
            let weights = &self.field[..];
            // Undamped rods and round ones skip whole blocks.
            if weights.iter().all(|weight| *weight == 0.0) {
                continue;
            }
            system.grid.basis.test_pair(
                weights,
                row,
                column,
                &mut self.viscosity,
                system.grid.unknowns,
            );
        }
    }

    /// Adds the derivative of the drag to D: −c |q|∘q along the body axes has the damping 2 c |q|.
    fn add_drag(
        &mut self,
        system: &RodEquations,
        conditions: &SolveConditions,
        workspace: &Workspace,
        variation: &ShapeVariation,
    ) {
        let drag = system.params.drag_n_s2_m3;
        if drag == 0.0 {
            return;
        }
        for (g, node) in system.grid.nodes.iter().enumerate() {
            let r = &workspace.shape.node_r[g];
            let velocity =
                r.tr_mul(&conditions.motion.node_velocity(g, &workspace.shape.node_p[g]));
            let damping = Matrix3::from_diagonal(&(velocity.abs() * (2.0 * drag * node.weight_m)));
            let n = system.grid.unknowns;
            add_gram(
                &mut self.viscosity,
                n,
                n,
                &variation.node_move[g],
                &(r * damping * r.transpose()),
            );
        }
    }

    /// M: the Gram matrix of all displacements, weighted by mass. Displacements are gathered by
    /// unknown, so that each entry is one dot product.
    #[inline(always)]
    fn add_inertia(
        &mut self,
        system: &RodEquations,
        workspace: &Workspace,
        variation: &ShapeVariation,
    ) {
        let n = system.grid.unknowns;
        let length = self.gathered.len() / n.max(1);
        let mut next = 0;
        for (g, section) in system.sections.iter().enumerate() {
            // √m on both factors of a product weights it by m.
            let root = (section.mass_kg_m * system.grid.nodes[g].weight_m).sqrt();
            gather(&mut self.gathered, length, &mut next, &variation.node_move[g], root);
        }
        for mass in &system.masses {
            gather(
                &mut self.gathered,
                length,
                &mut next,
                &variation.end_move[mass.end],
                mass.mass_kg.sqrt(),
            );
        }
        for row in 0..n {
            let row_moves = &self.gathered[row * length..(row + 1) * length];
            for column in row..n {
                // M is symmetric, so half of the products suffice.
                let sum = dot(row_moves, &self.gathered[column * length..(column + 1) * length]);
                self.inertia[row * n + column] = sum;
                self.inertia[column * n + row] = sum;
            }
        }
        for mass in system.masses.iter().filter(|mass| mass.turns()) {
            let r = &workspace.shape.end_r[mass.end];
            // Rotary inertia is constant in body axes; displacements are in the world's.
            let inertia = r * Matrix3::from_diagonal(&mass.inertia_kg_m2) * r.transpose();
            add_gram(&mut self.inertia, n, n, &variation.end_turn[mass.end], &inertia);
        }
    }
}

/// Writes `factor` times a displacement to places `next`, `next + 1`, `next + 2` of every unknown's
/// row.
#[inline(always)]
fn gather(rows: &mut [f64], length: usize, next: &mut usize, from: &VectorDerivative, factor: f64) {
    for values in from.rows() {
        let unknowns = rows.len() / length.max(1);
        for (k, value) in values[..unknowns].iter().enumerate() {
            rows[k * length + *next] = factor * value;
        }
        *next += 1;
    }
}

/// Adds `directionᵀ weightᵀ direction` to the first `n` rows and columns of a row-major matrix with
/// rows of `size`.
pub(super) fn add_gram(
    out: &mut [f64],
    n: usize,
    size: usize,
    direction: &VectorDerivative,
    weight: &Matrix3<f64>,
) {
    let [x, y, z] = direction.rows().map(|row| &row[..n]);
    for i in 0..n {
        let w = weight * Vector3::new(x[i], y[i], z[i]);
        let row = &mut out[i * size..i * size + n];
        let columns = x.iter().zip(y).zip(z);
        for (slot, ((x, y), z)) in row.iter_mut().zip(columns) {
            *slot += w.x * x + w.y * y + w.z * z;
        }
    }
}
