//! Analytic derivative of the discrete equations, K + rate·D + rate²·M. When the time step changes,
//! only the sum and its factorisation are recomputed.
//!
//! The wrench that a cross-section carries varies with the positions of the loads beyond it, δM = Σ
//! (δp_k − δp) × f_k, and its components in the body with the orientation, δ(Rᵀ M) = Rᵀ (δM − δθ ×
//! M). Inertia is the Gram matrix of the displacements, M = Σ m_k δp_kᵀ δp_k.
//!
//! Of the friction of tendons, what a change of shape does to the mobilised share under a prescribed
//! tension is left out: the iteration contracts without it.

use nalgebra::{DMatrix, Vector3};

use super::boundary_conditions::{SolveConditions, TendonConstraint};
use super::rates::RateMatrices;
use super::system::{RodEquations, Workspace};
use super::variation::ShapeVariation;
use super::world_vectors::{VectorDerivative, padded};
use crate::math::{matrix3, rotation, vectorised};
use crate::rod::discretisation::cell::COMPONENTS;
use crate::rod::discretisation::grid::Grid;
use crate::rod::params::tendon::Tendon;

/// Buffers for the derivative of one rod's equations.
#[derive(Clone, Debug)]
pub(crate) struct Derivative {
    pub(crate) variation: ShapeVariation,
    /// Row-major K with the borders d balance / d tension and d length / d unknown.
    pub(crate) stiffness: Vec<f64>,
    /// D and M: of the last derivative in motion, or of the last call of
    /// [`Derivative::update_rates`].
    pub(crate) rates: RateMatrices,
    /// Σ δp × f of all loads distal to a cell end, and the same including the rest of the cell
    /// distal to a Gauss point.
    beyond: VectorDerivative,
    moment: VectorDerivative,
    /// Σ δf and Σ p × δf + δm of the distal follower loads; `None` without any.
    follower: Option<[VectorDerivative; 2]>,
    wrench_rows: [Vec<f64>; COMPONENTS],
    /// For each tendon, then each Gauss point: derivative of the angle by which the path has turned
    /// there; empty without friction.
    turns: Vec<Vec<f64>>,
    border: Vec<f64>,
    /// Room for a field over the Gauss points.
    field: Vec<f64>,
}

impl Derivative {
    pub(crate) fn new(system: &RodEquations) -> Derivative {
        let n = system.grid.unknowns;
        let zero = VectorDerivative::zeros(n);
        let has_friction = system.params.tendons.iter().any(Tendon::has_friction);
        let paths = if has_friction { system.guides.len() } else { 0 };
        let follows = system.constant_loads.points.iter().any(|(_, load)| load.follows);
        Derivative {
            variation: ShapeVariation::new(&system.grid),
            stiffness: vec![0.0; system.size() * system.size()],
            rates: RateMatrices::new(system),
            follower: follows.then(|| [zero.clone(), zero.clone()]),
            turns: vec![vec![0.0; padded(n)]; paths],
            beyond: zero.clone(),
            moment: zero,
            wrench_rows: std::array::from_fn(|_| vec![0.0; padded(n)]),
            border: vec![0.0; n],
            field: vec![0.0; COMPONENTS * system.grid.nodes.len()],
        }
    }

    /// Derivative of the residual that [`RodEquations::evaluate`] has left in `workspace`.
    /// Viscosity and inertia are omitted for a rod at rest.
    pub(crate) fn update(
        &mut self,
        system: &RodEquations,
        unknowns: &[f64],
        conditions: &SolveConditions,
        workspace: &Workspace,
    ) {
        vectorised!(self.update_all(system, unknowns, conditions, workspace));
    }

    #[inline(always)]
    fn update_all(
        &mut self,
        system: &RodEquations,
        unknowns: &[f64],
        conditions: &SolveConditions,
        workspace: &Workspace,
    ) {
        // All below needs δp and δθ of every Gauss point and cell end.
        self.variation.update(&system.grid, &workspace.shape);
        self.update_turns(system, unknowns, workspace);
        self.stiffness.fill(0.0);
        self.beyond.fill_zero();
        self.follower.iter_mut().flatten().for_each(VectorDerivative::fill_zero);
        // From tip to base, so that `beyond` holds the loads that a cross-section carries.
        for c in (0..system.grid.cell_lengths_m.len()).rev() {
            self.add_end_loads(system, c + 1, conditions, workspace);
            for row in 0..2 {
                self.node_moment(system, c, row, workspace);
                self.node_rows(system, 2 * c + row, unknowns, workspace);
            }
            let half = 0.5 * system.grid.cell_lengths_m[c];
            for g in [2 * c, 2 * c + 1] {
                self.beyond.add_cross(
                    &self.variation.node_move[g],
                    &workspace.loads.node_f[g],
                    half,
                );
            }
        }
        if !workspace.touches.is_empty() {
            self.add_contact(system, workspace);
        }
        self.tendon_border(system, conditions, workspace);
        if conditions.motion.rate > 0.0 {
            self.rates.update(system, conditions, workspace, &self.variation);
        }
    }

    /// K + rate·D + rate²·M with the tendon rows that belong to the taut set of `conditions`.
    pub(crate) fn matrix(
        &self,
        system: &RodEquations,
        conditions: &SolveConditions,
    ) -> DMatrix<f64> {
        let (n, size) = (system.grid.unknowns, system.size());
        // Filled by columns; K is stored by rows, so this is its transpose until the end.
        let mut matrix = DMatrix::from_column_slice(size, size, &self.stiffness);
        let rate = conditions.motion.rate;
        if rate > 0.0 {
            for row in 0..n {
                let column = &mut matrix.as_mut_slice()[row * size..row * size + n];
                column
                    .iter_mut()
                    .zip(self.rates.row(row))
                    .for_each(|(k, (d, m))| *k += rate * (d + rate * m));
            }
        }
        for (i, constraint) in conditions.constraints.iter().enumerate() {
            if !matches!(constraint, TendonConstraint::Length(_)) || !conditions.taut[i] {
                // A slack tendon, or one of given tension, has an identity row: its unknown stays.
                matrix.column_mut(n + i).fill(0.0);
                matrix[(n + i, n + i)] = 1.0;
            }
        }
        matrix.transpose_mut();
        matrix
    }

    /// D and M of a rod at rest, for the shape of the last derivative.
    pub(crate) fn update_rates(
        &mut self,
        system: &RodEquations,
        conditions: &SolveConditions,
        workspace: &Workspace,
    ) {
        self.rates.update(system, conditions, workspace, &self.variation);
    }

    /// First-order change of the path length of tendon `i` when the coefficients change by `step`,
    /// metres.
    pub(crate) fn length_change_m(&self, system: &RodEquations, i: usize, step: &[f64]) -> f64 {
        let row = (system.grid.unknowns + i) * system.size();
        self.stiffness[row..row + step.len()].iter().zip(step).map(|(a, b)| a * b).sum()
    }

    /// Adds the forces on cell end `end`.
    #[inline(always)]
    fn add_end_loads(
        &mut self,
        system: &RodEquations,
        end: usize,
        conditions: &SolveConditions,
        workspace: &Workspace,
    ) {
        let force = &workspace.loads.end_f[end];
        if *force != Vector3::zeros() {
            self.beyond.add_cross(&self.variation.end_move[end], force, 1.0);
        }
        let Some([force, moment]) = &mut self.follower else { return };
        for (_, load) in system
            .constant_loads
            .points
            .iter()
            .filter(|(carrier, load)| *carrier == end && load.follows)
        {
            let (f, m) = load.in_world(&workspace.shape.end_r[end], conditions.loads.share);
            let turn = &self.variation.end_turn[end];
            force.add_cross(turn, &f, 1.0);
            moment.add_cross(turn, &m, 1.0);
            moment.add_arm_cross(&workspace.shape.end_p[end], turn, &f);
        }
    }

    /// Σ δp × f of all loads distal to Gauss point `row` of cell `c`.
    #[inline(always)]
    fn node_moment(&mut self, system: &RodEquations, c: usize, row: usize, workspace: &Workspace) {
        let h = system.grid.cell_lengths_m[c];
        let partial = Grid::partial_weights(h);
        self.moment.copy_from(&self.beyond);
        for source in 0..2 {
            let k = 2 * c + source;
            // The part of the cell that lies beyond this Gauss point.
            let weight = 0.5 * h - partial[row][source];
            self.moment.add_cross(&self.variation.node_move[k], &workspace.loads.node_f[k], weight);
        }
    }

    /// Adds the rows of K that Gauss point `g` contributes to.
    #[inline(always)]
    fn node_rows(
        &mut self,
        system: &RodEquations,
        g: usize,
        unknowns: &[f64],
        workspace: &Workspace,
    ) {
        let (turn, moved) = (&self.variation.node_turn[g], &self.variation.node_move[g]);
        // δM = Σ δp_k × f_k − δp × F: arms are measured from this cross-section.
        self.moment.add_cross(moved, &workspace.loads.force[g], -1.0);
        self.moment.add_cross(turn, &workspace.loads.moment[g], -1.0);
        let back = workspace.shape.node_r[g].transpose();
        // − Rᵀ (−δθ × F): only the rotation of the force in the body frame.
        let turned = matrix3::product(&back, &rotation::skew(&workspace.loads.force[g]));
        let (moments, forces) = self.wrench_rows.split_at_mut(3);
        for axis in 0..3 {
            let r = [back[(axis, 0)], back[(axis, 1)], back[(axis, 2)]];
            combine(&mut moments[axis], self.moment.rows(), r.map(|x| -x));
            combine(
                &mut forces[axis],
                turn.rows(),
                [turned[(axis, 0)], turned[(axis, 1)], turned[(axis, 2)]].map(|x| -x),
            );
        }
        self.add_followers(g, workspace);
        self.add_material(system, g, unknowns, workspace);
        self.add_tendon_friction(system, g, unknowns, workspace);
        self.project_rows(system, g, workspace);
    }

    /// Adds the rotation of follower loads distal to Gauss point `g`.
    fn add_followers(&mut self, g: usize, workspace: &Workspace) {
        let Some([force, moment]) = &self.follower else { return };
        let mut about = moment.clone();
        about.add_cross(force, &workspace.shape.node_p[g], 1.0);
        let back = workspace.shape.node_r[g].transpose();
        for axis in 0..3 {
            for k in 0..self.wrench_rows[0].len() {
                let of = |t: &VectorDerivative| {
                    (0..3).map(|b| back[(axis, b)] * t.row(b)[k]).sum::<f64>()
                };
                self.wrench_rows[axis][k] -= of(&about);
                self.wrench_rows[axis + 3][k] -= of(force);
            }
        }
    }

    /// Adds the derivative of elastic, history and tendon wrenches: local, through the strain
    /// alone.
    #[inline(always)]
    fn add_material(
        &mut self,
        system: &RodEquations,
        g: usize,
        unknowns: &[f64],
        workspace: &Workspace,
    ) {
        let node = &system.grid.nodes[g];
        let stiffness = system.tendon_stiffness(g, &unknowns[system.grid.unknowns..], workspace);
        for component in 0..COMPONENTS {
            let strain = workspace.shape.compliance[g].column(component);
            let mut change = [0.0; COMPONENTS];
            change[component] = 1.0;
            for row in 0..COMPONENTS {
                for col in 0..COMPONENTS {
                    change[row] += stiffness[row][col] * strain[col];
                }
            }
            for row in 0..2 {
                for col in 0..2 {
                    change[row] += workspace.history_tangent[g][row][col] * strain[col];
                }
            }
            let columns =
                node.offset[component]..node.offset[component] + system.grid.modes[component];
            for (rows, value) in self.wrench_rows.iter_mut().zip(change) {
                for (slot, basis) in rows[columns.clone()].iter_mut().zip(&node.basis) {
                    *slot += value * basis;
                }
            }
        }
    }

    /// The angles by which the paths of tendons with mobilised friction turn.
    fn update_turns(&mut self, system: &RodEquations, unknowns: &[f64], workspace: &Workspace) {
        if self.turns.is_empty() {
            return;
        }
        let points = system.grid.nodes.len();
        for (i, rows) in self.turns.chunks_mut(points).enumerate() {
            if system.friction_rate(i, workspace) != 0.0
                && unknowns[system.grid.unknowns + i] != 0.0
            {
                rows.iter_mut().for_each(|row| row.fill(0.0));
                system.turn_derivative(i, workspace, &self.variation, rows);
            }
        }
    }

    /// Adds the change of the tensions at Gauss point `g` with the angle by which the paths turn.
    #[inline(always)]
    fn add_tendon_friction(
        &mut self,
        system: &RodEquations,
        g: usize,
        unknowns: &[f64],
        workspace: &Workspace,
    ) {
        let points = system.grid.nodes.len();
        let count = if self.turns.is_empty() { 0 } else { system.params.tendons.len() };
        for i in 0..count {
            // τ(s) = τ(0) exp(−μ σ Θ).
            let by_turn_n = unknowns[system.grid.unknowns + i]
                * workspace.tension_shares[g * count + i]
                * system.friction_rate(i, workspace);
            if by_turn_n == 0.0 {
                continue;
            }
            let pull = system.tendon_wrench(g, i, workspace);
            for (rows, pull) in self.wrench_rows.iter_mut().zip(pull) {
                let turn = &self.turns[i * points + g];
                rows.iter_mut().zip(turn).for_each(|(slot, turn)| *slot += by_turn_n * pull * turn);
            }
        }
    }

    /// Multiplies with the compliance and the test polynomials and adds to the rows of this
    /// element.
    #[inline(always)]
    fn project_rows(&mut self, system: &RodEquations, g: usize, workspace: &Workspace) {
        let node = &system.grid.nodes[g];
        let (n, size) = (system.grid.unknowns, system.size());
        let [a, b, d] = workspace.shape.compliance[g].bend;
        let (first, rest) = self.wrench_rows.split_at_mut(1);
        for (x, y) in first[0].iter_mut().zip(rest[0].iter_mut()) {
            (*x, *y) = (a * *x + b * *y, b * *x + d * *y);
        }
        for component in 0..COMPONENTS {
            let diagonal = match component {
                0 | 1 => 1.0,
                5 => workspace.axial_weight[g],
                _ => workspace.shape.compliance[g].diagonal[component - 2],
            };
            for j in 0..system.grid.modes[component] {
                let weight = node.weight_m * node.basis[j] * diagonal;
                let start = (node.offset[component] + j) * size;
                let row = &mut self.stiffness[start..start + n];
                for (slot, value) in row.iter_mut().zip(&self.wrench_rows[component]) {
                    *slot += weight * value;
                }
            }
        }
    }

    /// d balance / d tension, and its transpose d length / d unknown (the two differ only where
    /// weights are held or the tendon has friction).
    #[inline(always)]
    fn tendon_border(
        &mut self,
        system: &RodEquations,
        conditions: &SolveConditions,
        workspace: &Workspace,
    ) {
        let (n, size, points) = (system.grid.unknowns, system.size(), system.grid.basis.points);
        for (i, constraint) in conditions.constraints.iter().enumerate() {
            for (g, node) in system.grid.nodes.iter().enumerate() {
                let strain =
                    workspace.shape.compliance[g].apply(&system.tendon_wrench(g, i, workspace));
                (0..COMPONENTS)
                    .for_each(|c| self.field[c * points + g] = node.weight_m * strain[c]);
            }
            self.border.fill(0.0);
            system.grid.basis.test(&self.field, &mut self.border);
            self.stiffness[(n + i) * size..][..n].copy_from_slice(&self.border);
            // Held weights or friction make the border unsymmetric.
            if workspace.weights_frozen || system.params.tendons[i].has_friction() {
                for (g, node) in system.grid.nodes.iter().enumerate() {
                    let strain =
                        workspace.weighted_strain(g, &system.tendon_wrench(g, i, workspace));
                    let weight_m = node.weight_m
                        * workspace.tension_shares[g * system.params.tendons.len() + i];
                    (0..COMPONENTS).for_each(|c| self.field[c * points + g] = weight_m * strain[c]);
                }
                self.border.fill(0.0);
                system.grid.basis.test(&self.field, &mut self.border);
            }
            for (k, value) in self.border.iter().enumerate() {
                self.stiffness[k * size + n + i] = *value;
            }
            let pull = if let TendonConstraint::Length(pull) = *constraint { pull } else { 0.0 };
            // The drive's stretch under tension lengthens the tendon.
            self.stiffness[(n + i) * size + n + i] = -system.params.tendons[i].compliance_at(pull);
        }
    }
}

/// `out = a·x + b·y + c·z`.
#[inline(always)]
fn combine(out: &mut [f64], [x, y, z]: [&[f64]; 3], [a, b, c]: [f64; 3]) {
    for (out, ((x, y), z)) in out.iter_mut().zip(x.iter().zip(y).zip(z)) {
        *out = a * x + b * y + c * z;
    }
}
