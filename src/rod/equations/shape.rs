//! Forward kinematics: strains at the Gauss points from the internal wrench, then poses by one
//! fourth-order Magnus step per cell.

use nalgebra::{Matrix3, Vector3};

use super::material::{Compliance, Components, Section};
use crate::math::matrix3;
use crate::math::rotation::{self, Turns};
use crate::rod::discretisation::cell::GAUSS;
use crate::rod::discretisation::grid::Grid;

/// Poses and strains of a rod under given internal-wrench coefficients.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shape {
    /// Elastic internal wrench at the Gauss points.
    pub(crate) wrench: Vec<Components>,
    /// Strains there.
    pub(crate) strain: Vec<Components>,
    /// d strain / d wrench there.
    pub(crate) compliance: Vec<Compliance>,
    /// Orientation at the Gauss points, columns are the body axes.
    pub(crate) node_r: Vec<Matrix3<f64>>,
    /// Position of the Gauss points, metres.
    pub(crate) node_p: Vec<Vector3<f64>>,
    /// Orientation at the cell ends.
    pub(crate) end_r: Vec<Matrix3<f64>>,
    /// Position of the cell ends, metres.
    pub(crate) end_p: Vec<Vector3<f64>>,
    /// Room for the wrench as a field, and for the rotations of every cell.
    field: Vec<f64>,
    turns: Turns,
}

impl Shape {
    /// Room for the shape of a rod on `grid` with its base at the given pose.
    pub(crate) fn new(grid: &Grid, base_r: Matrix3<f64>, base_p: Vector3<f64>) -> Shape {
        let (nodes, ends) = (grid.nodes.len(), grid.boundaries_m.len());
        Shape {
            wrench: vec![[0.0; 6]; nodes],
            strain: vec![[0.0; 6]; nodes],
            compliance: vec![Compliance::default(); nodes],
            node_r: vec![base_r; nodes],
            node_p: vec![base_p; nodes],
            end_r: vec![base_r; ends],
            end_p: vec![base_p; ends],
            field: vec![0.0; 6 * nodes],
            turns: Turns::new(3 * grid.cell_lengths_m.len()),
        }
    }

    /// Copies `other` without allocating.
    pub(crate) fn copy_from(&mut self, other: &Shape) {
        self.wrench.clone_from(&other.wrench);
        self.strain.clone_from(&other.strain);
        self.compliance.clone_from(&other.compliance);
        self.node_r.clone_from(&other.node_r);
        self.node_p.clone_from(&other.node_p);
        self.end_r.clone_from(&other.end_r);
        self.end_p.clone_from(&other.end_p);
    }

    /// Computes everything from the polynomial coefficients.
    #[inline(always)]
    pub(crate) fn update(&mut self, grid: &Grid, sections: &[Section], coefficients: &[f64]) {
        grid.basis.expand(coefficients, &mut self.field);
        let points = grid.basis.points;
        for g in 0..points {
            let wrench: Components = std::array::from_fn(|c| self.field[c * points + g]);
            (self.strain[g], self.compliance[g]) = sections[g].strain(&wrench);
            self.wrench[g] = wrench;
        }
        self.integrate(grid);
    }

    /// Computes strains and poses from an arbitrary wrench at each Gauss point; the compliances
    /// stay. Cells in which the spine begins to saturate get the exact length.
    #[inline(always)]
    pub(crate) fn update_from(&mut self, grid: &Grid, sections: &[Section], wrench: &[Components]) {
        for (g, local) in wrench.iter().enumerate() {
            self.strain[g] = sections[g].strain(local).0;
            self.wrench[g] = *local;
        }
        for (c, &cell_m) in grid.cell_lengths_m.iter().enumerate() {
            let [a, b] = [2 * c, 2 * c + 1];
            // The two-point rule misses the kink within a cell; the mean stretch makes up for it.
            let missing_stretch = sections[a].kink_m(wrench[a][5], wrench[b][5], cell_m) / cell_m;
            self.strain[a][5] += missing_stretch;
            self.strain[b][5] += missing_stretch;
        }
        self.integrate(grid);
    }

    /// Poses from the strains.
    #[inline(always)]
    fn integrate(&mut self, grid: &Grid) {
        for (c, &cell_m) in grid.cell_lengths_m.iter().enumerate() {
            self.read_turns(c, cell_m);
        }
        // All cells at once, for vector instructions; products of poses come afterwards.
        self.turns.exponentiate();
        for (c, &cell_m) in grid.cell_lengths_m.iter().enumerate() {
            self.advance(c, cell_m);
        }
    }

    /// Rotation vectors from the start of cell `c` to its Gauss points and its end. For a linear
    /// curvature over a length x they are ∫u + (x/h)³ √3 h²/12 u₁×u₂ (Magnus expansion).
    #[inline(always)]
    fn read_turns(&mut self, c: usize, h: f64) {
        let u1 = Vector3::from_row_slice(&self.strain[2 * c][..3]);
        let u2 = Vector3::from_row_slice(&self.strain[2 * c + 1][..3]);
        // √3/12 h² = GAUSS/2 h², since GAUSS is √3/6.
        let commutator = u1.cross(&u2) * (0.5 * GAUSS * h * h);
        let weights = Grid::partial_weights(h);
        for (row, share) in [(0, 0.5 - GAUSS), (1, 0.5 + GAUSS)] {
            let turn =
                u1 * weights[row][0] + u2 * weights[row][1] + commutator * (share * share * share);
            self.turns.set(3 * c + row, &turn);
        }
        self.turns.set(3 * c + 2, &((u1 + u2) * (0.5 * h) + commutator));
    }

    /// Poses at the Gauss points and the end of cell `c`; positions use the same Gauss points as
    /// rotations.
    #[inline(always)]
    fn advance(&mut self, c: usize, h: f64) {
        let (first, second) = (2 * c, 2 * c + 1);
        let weights = Grid::partial_weights(h);
        let start = self.end_r[c];
        self.node_r[first] = matrix3::product(&start, &self.turns.matrix(3 * c));
        self.node_r[second] = matrix3::product(&start, &self.turns.matrix(3 * c + 1));
        self.end_r[c + 1] = matrix3::product(&start, &self.turns.matrix(3 * c + 2));
        let d1 = matrix3::times(&self.node_r[first], &self.strain[first][3..]);
        let d2 = matrix3::times(&self.node_r[second], &self.strain[second][3..]);
        let p = self.end_p[c];
        self.node_p[first] = p + d1 * weights[0][0] + d2 * weights[0][1];
        self.node_p[second] = p + d1 * weights[1][0] + d2 * weights[1][1];
        self.end_p[c + 1] = p + (d1 + d2) * (0.5 * h);
    }

    /// Position and orientation at `position_m` from the base, inside the cell that holds it:
    /// strains linear in the cell, positions by two Gauss points from the start of the cell to the
    /// place. Of fourth order in the turn of the cell, of third in how strains bend within it.
    pub(crate) fn pose_at(&self, grid: &Grid, position_m: f64) -> (Vector3<f64>, Matrix3<f64>) {
        let last = grid.cell_lengths_m.len() - 1;
        let c = grid.boundaries_m[1..=last].partition_point(|&end| end <= position_m);
        let h = grid.cell_lengths_m[c];
        let x = (position_m - grid.boundaries_m[c]).clamp(0.0, h);
        let part = |g: usize, from: usize| Vector3::from_row_slice(&self.strain[g][from..from + 3]);
        let (u1, u2) = (part(2 * c, 0), part(2 * c + 1, 0));
        let rotation = |x: f64| {
            // Integral from the start of the cell of the line through the values at its two Gauss
            // points.
            let skew = (x * x - x * h) / (4.0 * GAUSS * h);
            let commutator = u1.cross(&u2) * (0.5 * GAUSS * h * h * (x / h).powi(3));
            self.end_r[c]
                * rotation::exp(&(u1 * (0.5 * x - skew) + u2 * (0.5 * x + skew) + commutator))
        };
        let tangent = |x: f64| {
            let second = (x / h - (0.5 - GAUSS)) / (2.0 * GAUSS);
            rotation(x) * (part(2 * c, 3) * (1.0 - second) + part(2 * c + 1, 3) * second)
        };
        let moved = (tangent(x * (0.5 - GAUSS)) + tangent(x * (0.5 + GAUSS))) * (0.5 * x);
        (self.end_p[c] + moved, rotation(x))
    }

    /// Position of the tip, metres.
    pub(crate) fn tip_m(&self) -> Vector3<f64> {
        self.end_p[self.end_p.len() - 1]
    }

    /// Orientation of the tip.
    pub(crate) fn tip_rotation(&self) -> Matrix3<f64> {
        self.end_r[self.end_r.len() - 1]
    }
}

/// Distance between the tips of two shapes, metres. A rotation counts as angle times the length of
/// the rod.
pub(crate) fn distance_m(a: &Shape, b: &Shape, length_m: f64) -> f64 {
    let moved = (a.tip_m() - b.tip_m()).norm();
    let turned = (a.tip_rotation() - b.tip_rotation()).norm() * length_m;
    // NaN must not count as agreement.
    if moved.is_finite() && turned.is_finite() { moved.max(turned) } else { f64::INFINITY }
}
