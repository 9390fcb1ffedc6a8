//! A-posteriori estimate of the tip error due to the spatial discretisation (docs/method/robustness.md).

use nalgebra::Vector3;

use crate::rod::equations::material::Components;
use crate::rod::equations::shape::Shape;
use crate::rod::equations::system::{RodEquations, Workspace};
use crate::rod::state::rod::Rod;

/// Least tendon offset as a share of the length: closer tendons shorten the rod rather than bend
/// it.
const MIN_OFFSET_SHARE: f64 = 0.01;
/// Safety factor on the one Picard iteration, which is the first term of a series
/// (docs/method/robustness.md).
const BALANCE_SAFETY_FACTOR: f64 = 15.0;
/// The error of the two-point Gauss rule is h⁵ f⁗ / 4320; a factor of three covers products of
/// fields.
const CELL_ERROR: f64 = 3.0 / 4320.0;
/// Error of the fourth-order Magnus step over its commutator times the squared angle of the cell.
const MAGNUS_ERROR: f64 = 1.0 / 30.0;

/// Tip errors from quadrature and from truncated polynomials, metres, as estimated on one grid.
pub(crate) struct ErrorEstimate {
    pub(crate) cells_m: f64,
    pub(crate) balance_m: f64,
}

impl ErrorEstimate {
    pub(crate) fn plain_m(&self) -> f64 {
        self.cells_m + self.balance_m
    }

    pub(crate) fn cautious_m(&self) -> f64 {
        let estimate_m = self.cells_m + BALANCE_SAFETY_FACTOR * self.balance_m;
        // NaN must not count as small.
        if estimate_m.is_finite() { estimate_m } else { f64::INFINITY }
    }
}

impl RodEquations {
    /// Tip error due to quadrature, metres: from the bending angle of each cell, out-of-plane
    /// bending, and the onset of spine saturation inside a cell.
    fn cell_error_m(&self, shape: &Shape, taut: &[bool]) -> f64 {
        let strain = &shape.strain;
        let mut total = 0.0;
        for (c, &cell_m) in self.grid.cell_lengths_m.iter().enumerate() {
            let (h, a, b) = (cell_m, &strain[2 * c], &strain[2 * c + 1]);
            let angle2 = squared_curvature(a).max(squared_curvature(b)) * h * h;
            let cross =
                [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
            // The Magnus expansion is exact for plane bending, where the commutator vanishes.
            let commutator =
                h * h * (cross[0].powi(2) + cross[1].powi(2) + cross[2].powi(2)).sqrt();
            total += CELL_ERROR * angle2 * angle2 * h * a[5].abs().max(b[5].abs());
            total += MAGNUS_ERROR * commutator * angle2 * self.params.length_m();
        }
        total + self.kink_error_m(shape, taut)
    }

    /// Contribution of the onset of saturation. It depends on where in its cell the kink lies, so
    /// that two grids may agree by chance.
    fn kink_error_m(&self, shape: &Shape, taut: &[bool]) -> f64 {
        let force = |g: usize| shape.wrench[g][5];
        let kink = |(c, &cell_m): (usize, &f64)| {
            self.sections[2 * c].kink_m(force(2 * c), force(2 * c + 1), cell_m).abs()
        };
        let kinks: f64 = self.grid.cell_lengths_m.iter().enumerate().map(kink).sum();
        if kinks == 0.0 {
            return 0.0;
        }
        // A taut tendon converts an axial length error into bending.
        let offset = |i: usize| {
            let along = self.guides.iter().skip(i).step_by(taut.len());
            along.map(|guide| guide.offset_m[0].hypot(guide.offset_m[1])).fold(0.0, f64::max)
        };
        let length_m = self.params.length_m();
        let nearest =
            (0..taut.len()).filter(|&i| taut[i]).map(offset).fold(f64::INFINITY, f64::min);
        kinks * (1.0 + length_m / nearest.max(MIN_OFFSET_SHARE * length_m))
    }

    /// The strain equivalent to the imbalance at Gauss point `g`, without its polynomial part
    /// (which the last iteration has corrected since).
    fn missing_strain(&self, g: usize, workspace: &Workspace) -> Components {
        let node = &self.grid.nodes[g];
        let mut strain = workspace.weighted_strain(g, &workspace.imbalance[g]);
        let element = node.offset[0] / self.grid.modes.iter().sum::<usize>();
        let per_length = 1.0 / (self.grid.elements_m[element + 1] - self.grid.elements_m[element]);
        for (c, value) in strain.iter_mut().enumerate() {
            let residuals =
                &workspace.residual[node.offset[c]..node.offset[c] + self.grid.modes[c]];
            // (2k + 1)/ℓ normalises the projection on the k-th polynomial.
            let mut normalisation = per_length;
            for (residual, basis) in residuals.iter().zip(&node.basis) {
                *value -= normalisation * residual * basis;
                normalisation += 2.0 * per_length;
            }
        }
        strain
    }

    /// Tip error due to truncated polynomials, metres. The imbalance at the Gauss points is
    /// orthogonal to the polynomials in use. As a missing strain it moves the tip by its product
    /// with a lever arm that is not a polynomial (one Picard iteration of the exact balance). Where
    /// it changes the length of a taut tendon, the tendon bends the rod by that length over its
    /// offset.
    pub(crate) fn balance_error_m(&self, workspace: &Workspace, taut: &[bool]) -> f64 {
        let tip = workspace.shape.tip_m();
        let missing_strain: Vec<Components> =
            (0..self.grid.nodes.len()).map(|g| self.missing_strain(g, workspace)).collect();
        let (mut moved, mut turned) = (Vector3::zeros(), Vector3::zeros());
        let mut bent_rad = 0.0;
        for i in (0..taut.len()).filter(|&i| taut[i]) {
            let (mut lengthening_m, mut offset) = (0.0, 0.0_f64);
            for (g, node) in self.grid.nodes.iter().enumerate() {
                let pull = self.tendon_wrench(g, i, workspace);
                lengthening_m += node.weight_m
                    * pull.iter().zip(&missing_strain[g]).map(|(a, b)| a * b).sum::<f64>();
                let [x, y] = self.guides[g * taut.len() + i].offset_m;
                offset = offset.max(x * x + y * y);
            }
            bent_rad +=
                lengthening_m.abs() / offset.sqrt().max(MIN_OFFSET_SHARE * self.params.length_m());
        }
        for (g, node) in self.grid.nodes.iter().enumerate() {
            let missing_strain = &missing_strain[g];
            let r = &workspace.shape.node_r[g];
            let turn = r
                * Vector3::new(missing_strain[0], missing_strain[1], missing_strain[2])
                * node.weight_m;
            let stretch = r
                * Vector3::new(missing_strain[3], missing_strain[4], missing_strain[5])
                * node.weight_m;
            // A missing curvature turns all that lies beyond it: lever arm to the tip.
            moved += stretch + turn.cross(&(tip - workspace.shape.node_p[g]));
            turned += turn;
        }
        moved.norm().max(turned.norm() * self.params.length_m()) + bent_rad * self.params.length_m()
    }
}

fn squared_curvature(strain: &Components) -> f64 {
    strain[0] * strain[0] + strain[1] * strain[1] + strain[2] * strain[2]
}

impl Rod {
    /// The estimate on this grid, from the last iteration of the solver.
    pub(crate) fn estimate(&self) -> ErrorEstimate {
        ErrorEstimate {
            cells_m: self.system.cell_error_m(&self.state.shape, &self.state.taut),
            balance_m: self.system.balance_error_m(&self.solver.workspace, &self.state.taut),
        }
    }
}
