//! Is an equilibrium one that the rod would stay in? (docs/robustness.md)
//!
//! Strains, elastic energy and tendon lengths are convex in each other, so that loads alone can make an equilibrium
//! unstable. A bound on what they can do settles most cases at once; the others are told by the tangent matrix, which is
//! the second derivative of the energy and has to be positive on all motions that the taut tendons allow.

use nalgebra::linalg::Schur;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::rod::equations::boundary_conditions::TendonConstraint;
use crate::rod::solver::status::SolveStatus;
use crate::rod::state::rod::Rod;

/// A bound below this share of the elastic stiffness proves stability; the rest is for shear and stretch.
const SAFE_SHARE: f64 = 0.8;
/// Compliance of a tendon that does not stretch, as a share of what the rod gives along it.
const STIFF: f64 = 1e-6;
/// By how much of its length the tip is pushed off an unstable equilibrium.
const PUSH: f64 = 0.02;
/// Iterations a row in which eigenvalues are looked for, at one precision and then at the next.
const SCHUR_ITERATIONS: usize = 40;
const SCHUR_PRECISIONS: [f64; 2] = [f64::EPSILON, 1e-11];

impl Rod {
    /// Leaves an equilibrium that is unstable for a stable one.
    pub(crate) fn leave_if_unstable(&mut self, holds: &[TendonConstraint]) -> SolveStatus {
        if self.is_stable_by_bound() {
            return SolveStatus::Converged;
        }
        for attempt in 0..2 {
            let Some(direction) = self.unstable_direction(holds) else { return SolveStatus::Converged };
            if attempt == 1 {
                break;
            }
            let size = self.system.size_of_step_m(&direction, &self.solver.workspace);
            let push = PUSH * self.system.params.length_m() / size;
            self.state.unknowns.iter_mut().zip(&direction).for_each(|(x, d)| *x += push * d);
            if self.relax_dynamically(holds, 1.0) != SolveStatus::Converged {
                break;
            }
        }
        SolveStatus::Unstable
    }

    /// Whether the loads are too small to buckle the rod. A force N(s) that a cross-section carries takes at most
    /// |N| |δθ|² + |∫N| |δθ| |δθ′| from the second variation of the energy, a moment M at most |M| |δθ| |δθ′|; with
    /// |δθ(s)|² ≤ s ∫|δθ′|² both are bounded by integrals that are compared with the least turning stiffness.
    pub(crate) fn is_stable_by_bound(&self) -> bool {
        let params = &self.system.params;
        let free = params.point_loads.is_empty() && params.moment_laws.is_empty();
        if !free {
            return false;
        }
        let (mut first, mut second, mut beyond) = (0.0, 0.0, 0.0);
        for (node, force) in self.system.grid.nodes.iter().zip(&self.solver.workspace.loads.force).rev() {
            let (s, weight, n) = (node.position_m, node.weight_m, force.norm());
            beyond += 0.5 * weight * n;
            first += weight * n * s;
            second += weight * s * beyond * beyond;
            beyond += 0.5 * weight * n;
        }
        let length = params.length_m();
        let bound = first + second.sqrt() + self.tip_load.moment_nm.norm() * length * std::f64::consts::FRAC_1_SQRT_2;
        bound * self.grid_level.softest < SAFE_SHARE
    }

    /// A motion that lowers the energy, as changes of the polynomial coefficients; none if the equilibrium is stable.
    pub(crate) fn unstable_direction(&mut self, holds: &[TendonConstraint]) -> Option<Vec<f64>> {
        self.solver.forget();
        if self.solve_static(holds, 1.0) != SolveStatus::Converged {
            return None;
        }
        let (n, size) = (self.system.grid.unknowns, self.system.size());
        let bordered = self.solver.derivative.stiffness();
        let scale: Vec<f64> =
            (0..n).map(|k| bordered[k * size + k].abs().max(f64::MIN_POSITIVE).sqrt().recip()).collect();
        let entry = |a: usize, b: usize| bordered[a * size + b] * scale[a] * scale[b];
        let mut matrix = DMatrix::from_fn(n, n, entry);
        for (i, hold) in holds.iter().enumerate() {
            if matches!(hold, TendonConstraint::Length(_)) && self.state.taut[i] {
                let row = &bordered[(n + i) * size..(n + i) * size + n];
                let pull = DVector::from_iterator(n, row.iter().zip(&scale).map(|(x, s)| x * s));
                let compliance = -bordered[(n + i) * size + n + i];
                let stiffness = 1.0 / compliance.max(STIFF * pull.norm_squared());
                matrix.ger(stiffness, &pull, &pull, 1.0);
            }
        }
        let symmetric = 0.5 * (&matrix + matrix.transpose());
        if symmetric.clone().cholesky().is_some() {
            return None;
        }
        // A moment that keeps its direction in space has no energy: then it is growth in time that tells.
        if grows_nowhere(matrix) {
            return None;
        }
        let eigen = SymmetricEigen::try_new(symmetric, f64::EPSILON, SCHUR_ITERATIONS * n)?;
        let direction = eigen.eigenvectors.column(eigen.eigenvalues.argmin().0);
        Some(direction.iter().zip(&scale).map(|(x, s)| x * s).collect())
    }
}

/// Whether all eigenvalues have positive real parts; false as well where they are not found.
fn grows_nowhere(matrix: DMatrix<f64>) -> bool {
    let most = SCHUR_ITERATIONS * matrix.nrows();
    // Double eigenvalues, as symmetric rods have them, keep the iteration from ever ending at the last digit.
    let schur = SCHUR_PRECISIONS.iter().find_map(|&precision| Schur::try_new(matrix.clone(), precision, most));
    schur.is_some_and(|schur| schur.complex_eigenvalues().iter().all(|value| value.re > 0.0))
}
