//! Eigenvalues of the linearised motion, for loads without a potential: M ẍ + D ẋ + K x = 0.
//!
//! With μ = 1/λ, K μ² + D μ + M = 0 needs no inverse of M, which is singular (the backbone has no
//! rotary inertia), and Re μ has the sign of Re λ.

use nalgebra::linalg::Schur;
use nalgebra::{Complex, DMatrix};

use crate::rod::equations::boundary_conditions::TendonConstraint;
use crate::rod::state::rod::Rod;

/// Real part over modulus beyond which an eigenvalue counts as growing. Of rods without damping all
/// have a modulus and, but for rounding, no real part.
const GROWTH_TOLERANCE: f64 = 1e-6;
/// Modes are judged up to this many times the lowest frequency; higher ones are the grid's rather
/// than the rod's.
const MAX_FREQUENCY_RATIO: f64 = 100.0;
/// Schur iterations per row, at one precision and then at the next: double eigenvalues of symmetric
/// rods may prevent convergence to the last digit.
const SCHUR_ITERATIONS: usize = 40;
const SCHUR_PRECISIONS: [f64; 4] = [f64::EPSILON, 1e-14, 1e-12, 1e-10];

/// Growing deviations from an equilibrium or a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Growth {
    /// None.
    None,
    /// They grow without oscillating. Largest modulus, 1/s.
    Divergence(f64),
    /// They oscillate as they grow. Largest modulus, 1/s.
    Flutter(f64),
}

impl Rod {
    /// What grows by the derivative that the solver holds, D and M included; `None` when the
    /// iteration fails or the rod has neither mass nor damping.
    pub(crate) fn growth(&self, constraints: &[TendonConstraint]) -> Option<Growth> {
        let n = self.system.grid.unknowns;
        let stiffness = self.tangent(constraints, 0.0).matrix;
        // D and M from the tangent K + s·D + s²·M at the rates 1 and 2.
        let (rate_one, rate_two) = (
            self.tangent(constraints, 1.0).matrix - &stiffness,
            self.tangent(constraints, 2.0).matrix - &stiffness,
        );
        let inertia = (&rate_two - &rate_one * 2.0) * 0.5;
        let damping = rate_one - &inertia;
        let factors = stiffness.lu();
        // Companion matrix of the quadratic eigenvalue problem in μ.
        let mut companion = DMatrix::zeros(2 * n, 2 * n);
        companion.view_mut((0, 0), (n, n)).copy_from(&-factors.solve(&damping)?);
        companion.view_mut((0, n), (n, n)).copy_from(&-factors.solve(&inertia)?);
        companion.view_mut((n, 0), (n, n)).fill_with_identity();
        let values = eigenvalues(companion)?;
        // The largest μ is the slowest mode, since μ = 1/λ.
        let lowest_frequency_mu = values.iter().map(|value| value.norm()).fold(0.0, f64::max);
        if lowest_frequency_mu == 0.0 {
            return None;
        }
        let judged =
            values.iter().filter(|value| value.norm() * MAX_FREQUENCY_RATIO > lowest_frequency_mu);
        let growing: Vec<&Complex<f64>> =
            judged.filter(|value| value.re > GROWTH_TOLERANCE * value.norm()).collect();
        let Some(rate) = growing.iter().map(|value| value.norm().recip()).reduce(f64::max) else {
            return Some(Growth::None);
        };
        // A real eigenvalue does not oscillate.
        let diverges =
            growing.iter().any(|value| value.im.abs() <= GROWTH_TOLERANCE * value.norm());
        Some(if diverges { Growth::Divergence(rate) } else { Growth::Flutter(rate) })
    }
}

/// Whether all eigenvalues have positive real parts; false when the iteration fails.
pub(crate) fn all_positive(matrix: DMatrix<f64>) -> bool {
    eigenvalues(matrix).is_some_and(|values| values.iter().all(|value| value.re > 0.0))
}

fn eigenvalues(matrix: DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    let max_iterations = SCHUR_ITERATIONS * matrix.nrows();
    let schur = SCHUR_PRECISIONS
        .iter()
        .find_map(|&precision| Schur::try_new(matrix.clone(), precision, max_iterations))?;
    Some(schur.complex_eigenvalues().iter().copied().collect())
}
