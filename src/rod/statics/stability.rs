//! Stability of equilibria (docs/robustness.md).
//!
//! Elastic energy and tendon lengths are convex in the strains, so that only loads can make an equilibrium unstable. A
//! bound on their effect settles most cases. The others are decided by the tangent matrix, the second derivative of the
//! energy, which must be positive on all motions that the taut tendons allow.

use nalgebra::linalg::Schur;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::rod::equations::boundary_conditions::TendonConstraint;
use crate::rod::solver::status::SolveStatus;
use crate::rod::state::rod::Rod;

/// A bound below this share of the elastic stiffness proves stability; the margin covers shear and stretch.
const SAFE_SHARE: f64 = 0.8;
/// Compliance assigned to an inextensible tendon, as a share of the compliance of the rod along it.
const STIFF: f64 = 1e-6;
/// Perturbation of the tip away from an unstable equilibrium, as a share of the length.
const PUSH: f64 = 0.02;
/// Schur iterations per row, at one precision and then at the next.
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

    /// Whether the loads are too small for buckling. A force N(s) contributes at most |N| |δθ|² + |∫N| |δθ| |δθ′| to
    /// the second variation of the energy, a moment M at most |M| |δθ| |δθ′|. With |δθ(s)|² ≤ s ∫|δθ′|² both are
    /// bounded by integrals that are compared with the least rotational stiffness.
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

    /// A direction of decreasing energy, as changes of the polynomial coefficients; `None` at a stable equilibrium.
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
        // A moment with a fixed direction in space is not conservative: growth in time decides.
        if grows_nowhere(matrix) {
            return None;
        }
        let eigen = SymmetricEigen::try_new(symmetric, f64::EPSILON, SCHUR_ITERATIONS * n)?;
        let direction = eigen.eigenvectors.column(eigen.eigenvalues.argmin().0);
        Some(direction.iter().zip(&scale).map(|(x, s)| x * s).collect())
    }
}

/// Whether all eigenvalues have positive real parts; false when the iteration fails.
fn grows_nowhere(matrix: DMatrix<f64>) -> bool {
    let most = SCHUR_ITERATIONS * matrix.nrows();
    // Double eigenvalues of symmetric rods may prevent convergence to the last digit.
    let schur = SCHUR_PRECISIONS.iter().find_map(|&precision| Schur::try_new(matrix.clone(), precision, most));
    schur.is_some_and(|schur| schur.complex_eigenvalues().iter().all(|value| value.re > 0.0))
}
