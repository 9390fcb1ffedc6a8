//! Analytic derivative of the discrete equations.
//!
//! World-frame variations obey δθ(s) = ∫ R δu and δp(s) = ∫ R δv + δθ × R v; the external wrench varies with the
//! positions of the loads and with the orientation of the section. Everything is kept as arrays over the unknowns
//! so that inner loops run over contiguous memory.

use nalgebra::{DMatrix, Matrix3, Vector3};

use super::conditions::{Conditions, Hold};
use super::grid::{COMPONENTS, Grid};
use super::section::Six;
use super::system::{System, Work};

/// Three rows (x, y, z) over the unknowns.
#[derive(Clone, Debug)]
pub(super) struct Triple {
    rows: [Vec<f64>; 3],
}

impl Triple {
    fn zeros(n: usize) -> Triple {
        Triple { rows: [vec![0.0; n], vec![0.0; n], vec![0.0; n]] }
    }

    /// Change that a change of the unknowns makes.
    pub(super) fn times(&self, change: &[f64]) -> Vector3<f64> {
        let row = |axis: usize| self.rows[axis].iter().zip(change).map(|(a, b)| a * b).sum();
        Vector3::new(row(0), row(1), row(2))
    }

    fn fill_zero(&mut self) {
        self.rows.iter_mut().for_each(|row| row.fill(0.0));
    }

    fn copy_from(&mut self, other: &Triple) {
        for (to, from) in self.rows.iter_mut().zip(&other.rows) {
            to.copy_from_slice(from);
        }
    }

    /// Adds `scale` × other.
    fn add(&mut self, other: &Triple, scale: f64) {
        for (to, from) in self.rows.iter_mut().zip(&other.rows) {
            to.iter_mut().zip(from).for_each(|(a, b)| *a += scale * b);
        }
    }

    /// Adds `scale` × (other × fixed).
    fn add_cross(&mut self, other: &Triple, fixed: &Vector3<f64>, scale: f64) {
        let f = fixed * scale;
        for axis in 0..3 {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            let (p, q) = (&other.rows[next], &other.rows[last]);
            let (f_last, f_next) = (f[last], f[next]);
            for ((a, b), c) in self.rows[axis].iter_mut().zip(p).zip(q) {
                *a += b * f_last - c * f_next;
            }
        }
    }
}

/// Room for the derivative of one rod's equations.
#[derive(Clone, Debug)]
pub(super) struct Derivative {
    /// δθ and δp at the Gauss points and the cell ends.
    node_turn: Vec<Triple>,
    node_move: Vec<Triple>,
    pub(super) end_turn: Vec<Triple>,
    pub(super) end_move: Vec<Triple>,
    /// World strain rates R A φ at the two Gauss points of a cell.
    turn_rate: [Triple; 2],
    move_rate: [Triple; 2],
    force: Triple,
    moment: Triple,
    node_force: Triple,
    node_moment: Triple,
    wrench_rows: [Vec<f64>; COMPONENTS],
    /// Row-major derivative of the equations; the right border holds d balance / d tension.
    rows: Vec<f64>,
}

impl Derivative {
    pub(super) fn new(system: &System) -> Derivative {
        let n = system.grid.unknowns;
        let (nodes, ends) = (system.grid.nodes.len(), system.grid.boundaries_m.len());
        let zero = Triple::zeros(n);
        Derivative {
            node_turn: vec![zero.clone(); nodes],
            node_move: vec![zero.clone(); nodes],
            end_turn: vec![zero.clone(); ends],
            end_move: vec![zero.clone(); ends],
            turn_rate: [zero.clone(), zero.clone()],
            move_rate: [zero.clone(), zero.clone()],
            force: zero.clone(),
            moment: zero.clone(),
            node_force: zero.clone(),
            node_moment: zero.clone(),
            wrench_rows: std::array::from_fn(|_| vec![0.0; n]),
            rows: vec![0.0; system.size() * system.size()],
        }
    }

    /// Derivative of the residual that [`System::evaluate`] has just left in `work`.
    pub(super) fn update(&mut self, system: &System, unknowns: &[f64], conditions: &Conditions, work: &Work) {
        self.rows.fill(0.0);
        self.kinematics(system, work);
        self.force.fill_zero();
        self.moment.fill_zero();
        for c in (0..system.grid.cells.len()).rev() {
            self.cell(system, c, unknowns, conditions, work);
        }
        self.tendon_border(system, conditions, work);
    }

    /// The matrix, with the tendon rows that belong to the taut set of `conditions`.
    pub(super) fn matrix(&self, system: &System, conditions: &Conditions) -> DMatrix<f64> {
        let (n, size) = (system.grid.unknowns, system.size());
        let mut matrix = DMatrix::from_row_slice(size, size, &self.rows);
        for (i, hold) in conditions.holds.iter().enumerate() {
            if !matches!(hold, Hold::Length(_)) || !conditions.taut[i] {
                matrix.row_mut(n + i).fill(0.0);
                matrix[(n + i, n + i)] = 1.0;
            }
        }
        matrix
    }

    /// First-order change of the path length of tendon `i` when the coefficients change by `step`, metres.
    pub(super) fn length_change_m(&self, system: &System, i: usize, step: &[f64]) -> f64 {
        let row = (system.grid.unknowns + i) * system.size();
        self.rows[row..row + step.len()].iter().zip(step).map(|(a, b)| a * b).sum()
    }

    /// Variations of orientation and position along the rod.
    fn kinematics(&mut self, system: &System, work: &Work) {
        let base_turn = Triple::zeros(system.grid.unknowns);
        self.end_turn[0].copy_from(&base_turn);
        self.end_move[0].copy_from(&base_turn);
        for (c, cell) in system.grid.cells.iter().enumerate() {
            let h = cell.length_m;
            let partial = Grid::partial_weights(h);
            for row in 0..2 {
                strain_rates(system, work, 2 * c + row, &mut self.turn_rate[row], &mut self.move_rate[row]);
            }
            for row in 0..2 {
                let turn = &mut self.node_turn[2 * c + row];
                turn.copy_from(&self.end_turn[c]);
                turn.add(&self.turn_rate[0], partial[row][0]);
                turn.add(&self.turn_rate[1], partial[row][1]);
                let v = Vector3::from_row_slice(&work.shape.strain[2 * c + row][3..]);
                let tangent = work.shape.node_r[2 * c + row] * v;
                self.move_rate[row].add_cross(turn, &tangent, 1.0);
            }
            for row in 0..2 {
                let moved = &mut self.node_move[2 * c + row];
                moved.copy_from(&self.end_move[c]);
                moved.add(&self.move_rate[0], partial[row][0]);
                moved.add(&self.move_rate[1], partial[row][1]);
            }
            let (before, after) = self.end_turn.split_at_mut(c + 1);
            after[0].copy_from(&before[c]);
            let (before_p, after_p) = self.end_move.split_at_mut(c + 1);
            after_p[0].copy_from(&before_p[c]);
            for row in 0..2 {
                after[0].add(&self.turn_rate[row], 0.5 * h);
                after_p[0].add(&self.move_rate[row], 0.5 * h);
            }
        }
    }

    /// Goes from the end of cell `c` to its start: variation of the carried wrench, and the rows of its Gauss points.
    fn cell(&mut self, system: &System, c: usize, unknowns: &[f64], conditions: &Conditions, work: &Work) {
        let h = system.grid.cells[c].length_m;
        let (shape, loads) = (&work.shape, &work.loads);
        let rate2 = conditions.motion.rate * conditions.motion.rate;
        for mass in system.masses.iter().filter(|mass| mass.end == c + 1) {
            self.force.add(&self.end_move[c + 1], -mass.mass_kg * rate2);
            let inertia =
                shape.end_r[c + 1] * Matrix3::from_diagonal(&mass.inertia_kg_m2) * shape.end_r[c + 1].transpose();
            add_product(&mut self.moment, &inertia, &self.end_turn[c + 1], -rate2);
        }
        let partial = Grid::partial_weights(h);
        let force = loads.cell_force[c];
        for row in 0..2 {
            let g = 2 * c + row;
            self.node_force.copy_from(&self.force);
            self.node_moment.copy_from(&self.moment);
            self.node_moment.add_cross(&self.end_move[c + 1], &force, 1.0);
            self.node_moment.add_cross(&self.node_move[g], &force, -1.0);
            self.node_moment.add_cross(&self.force, &(shape.end_p[c + 1] - shape.node_p[g]), -1.0);
            for other in 0..2 {
                let k = 2 * c + other;
                let weight = 0.5 * h - partial[row][other];
                let f = loads.node_f[k] * weight;
                let inertia = -system.sections[k].mass_kg_m * rate2 * weight;
                self.node_force.add(&self.node_move[k], inertia);
                self.node_moment.add_cross(&self.node_move[k], &f, 1.0);
                self.node_moment.add_cross(&self.node_move[g], &f, -1.0);
                self.node_moment.add_cross(&self.node_move[k], &(shape.node_p[k] - shape.node_p[g]), -inertia);
            }
            self.node_rows(system, g, unknowns, conditions, work);
        }
        self.moment.add_cross(&self.end_move[c + 1], &force, 1.0);
        self.moment.add_cross(&self.end_move[c], &force, -1.0);
        let arm = shape.end_p[c + 1] - shape.end_p[c];
        self.moment.add_cross(&self.force, &arm, -1.0);
        for k in [2 * c, 2 * c + 1] {
            let f = loads.node_f[k] * (0.5 * h);
            let inertia = -system.sections[k].mass_kg_m * rate2 * 0.5 * h;
            self.force.add(&self.node_move[k], inertia);
            self.moment.add_cross(&self.node_move[k], &f, 1.0);
            self.moment.add_cross(&self.end_move[c], &f, -1.0);
            self.moment.add_cross(&self.node_move[k], &(shape.node_p[k] - shape.end_p[c]), -inertia);
        }
    }

    /// Derivative of the weighted imbalance at Gauss point `g`.
    fn node_rows(&mut self, system: &System, g: usize, unknowns: &[f64], conditions: &Conditions, work: &Work) {
        let shape = &work.shape;
        let turn = &self.node_turn[g];
        // δ(Rᵀ M) = Rᵀ (δM − δθ × M), with the sign of an external wrench.
        self.node_moment.add_cross(turn, &work.loads.moment[g], -1.0);
        self.node_force.add_cross(turn, &work.loads.force[g], -1.0);
        let back = shape.node_r[g].transpose();
        for axis in 0..3 {
            let (m, f) = (&self.node_moment.rows, &self.node_force.rows);
            let r = [back[(axis, 0)], back[(axis, 1)], back[(axis, 2)]];
            for k in 0..m[0].len() {
                self.wrench_rows[axis][k] = -(r[0] * m[0][k] + r[1] * m[1][k] + r[2] * m[2][k]);
                self.wrench_rows[axis + 3][k] = -(r[0] * f[0][k] + r[1] * f[1][k] + r[2] * f[2][k]);
            }
        }
        self.add_material(system, g, unknowns, conditions, work);
        self.project_rows(system, g, work);
    }

    /// Adds the derivative of elastic, viscous, history and tendon wrenches: local, through the strain alone.
    fn add_material(&mut self, system: &System, g: usize, unknowns: &[f64], conditions: &Conditions, work: &Work) {
        let node = &system.grid.nodes[g];
        let stiffness = tendon_stiffness(system, g, &unknowns[system.grid.unknowns..], work);
        for component in 0..COMPONENTS {
            let strain = work.shape.compliance[g].column(component);
            let mut change = [0.0; COMPONENTS];
            change[component] = 1.0;
            for row in 0..COMPONENTS {
                change[row] += system.sections[g].viscosity[row] * conditions.motion.rate * strain[row];
                change[row] += (0..COMPONENTS).map(|col| stiffness[row][col] * strain[col]).sum::<f64>();
            }
            for row in 0..2 {
                change[row] += (0..2).map(|col| work.history_tangent[g][row][col] * strain[col]).sum::<f64>();
            }
            let columns = node.offset[component]..node.offset[component] + system.grid.modes[component];
            for (row, value) in change.iter().enumerate() {
                for (slot, basis) in self.wrench_rows[row][columns.clone()].iter_mut().zip(&node.basis) {
                    *slot += value * basis;
                }
            }
        }
    }

    /// Multiplies with the compliance and the test polynomials and adds to the rows of this element.
    fn project_rows(&mut self, system: &System, g: usize, work: &Work) {
        let node = &system.grid.nodes[g];
        let (n, size) = (system.grid.unknowns, system.size());
        let [a, b, d] = work.shape.compliance[g].bend;
        let (first, rest) = self.wrench_rows.split_at_mut(1);
        for (x, y) in first[0].iter_mut().zip(rest[0].iter_mut()) {
            (*x, *y) = (a * *x + b * *y, b * *x + d * *y);
        }
        for component in 0..COMPONENTS {
            let diagonal = if component < 2 { 1.0 } else { work.shape.compliance[g].diagonal[component - 2] };
            for j in 0..system.grid.modes[component] {
                let weight = node.weight_m * node.basis[j] * diagonal;
                let start = (node.offset[component] + j) * size;
                let row = &mut self.rows[start..start + n];
                for (slot, value) in row.iter_mut().zip(&self.wrench_rows[component]) {
                    *slot += weight * value;
                }
            }
        }
    }

    /// d balance / d tension and, being the same numbers, d length / d unknown.
    fn tendon_border(&mut self, system: &System, conditions: &Conditions, work: &Work) {
        let (n, size) = (system.grid.unknowns, system.size());
        let mut border = vec![0.0; n];
        for (i, hold) in conditions.holds.iter().enumerate() {
            border.fill(0.0);
            for g in 0..system.grid.nodes.len() {
                let pull = system.tendon_wrench(g, i, work);
                system.project(g, &work.shape.compliance[g].apply(&pull), &mut border);
            }
            for (k, value) in border.iter().enumerate() {
                self.rows[k * size + n + i] = *value;
                self.rows[(n + i) * size + k] = *value;
            }
            let pull = if let Hold::Length(pull) = *hold { pull } else { 0.0 };
            self.rows[(n + i) * size + n + i] = -system.params.tendons[i].compliance_at(pull);
        }
    }
}

/// World-frame strain variations at Gauss point `g`: R A φ for curvature (turn) and stretch (move).
fn strain_rates(system: &System, work: &Work, g: usize, turn: &mut Triple, moved: &mut Triple) {
    turn.fill_zero();
    moved.fill_zero();
    let node = &system.grid.nodes[g];
    let r = &work.shape.node_r[g];
    for component in 0..COMPONENTS {
        let strain = work.shape.compliance[g].column(component);
        let columns = node.offset[component]..node.offset[component] + system.grid.modes[component];
        let (target, part) = if component < 3 { (&mut *turn, &strain[..3]) } else { (&mut *moved, &strain[3..]) };
        let world = r * Vector3::from_row_slice(part);
        for axis in 0..3 {
            for (slot, basis) in target.rows[axis][columns.clone()].iter_mut().zip(&node.basis) {
                *slot = world[axis] * basis;
            }
        }
    }
}

/// Σ tension · ∂²length/∂strain² at Gauss point `g`: the stiffness that taut tendons add.
fn tendon_stiffness(system: &System, g: usize, tensions: &[f64], work: &Work) -> [Six; COMPONENTS] {
    let mut total = [[0.0; COMPONENTS]; COMPONENTS];
    for (i, &tension) in tensions.iter().enumerate() {
        let (t, stretch) = work.tangents[g * tensions.len() + i];
        if tension == 0.0 || stretch == 0.0 {
            continue;
        }
        let [x, y] = system.params.tendons[i].offset_m;
        // d path / d strain: columns u_x, u_y, u_z, then the identity.
        let columns = [
            Vector3::new(0.0, 0.0, y),
            Vector3::new(0.0, 0.0, -x),
            Vector3::new(-y, x, 0.0),
            Vector3::x(),
            Vector3::y(),
            Vector3::z(),
        ];
        let lateral = (Matrix3::identity() - t * t.transpose()) * (tension / stretch);
        for (a, left) in columns.iter().enumerate() {
            let image = lateral * left;
            for (b, right) in columns.iter().enumerate() {
                total[a][b] += image.dot(right);
            }
        }
    }
    total
}

/// `to += scale · matrix · from`.
fn add_product(to: &mut Triple, matrix: &Matrix3<f64>, from: &Triple, scale: f64) {
    for axis in 0..3 {
        for other in 0..3 {
            let factor = scale * matrix[(axis, other)];
            to.rows[axis].iter_mut().zip(&from.rows[other]).for_each(|(a, b)| *a += factor * b);
        }
    }
}
