//! The tangent of a rod on the motions that its taut tendons allow: K + s·D + s²·M.
//!
//! K is the second derivative of the energy. For a conservative rod K + s·D + s²·M with s ≥ 0 is
//! positive definite exactly if no deviation grows faster than exp(s t) (Sylvester's law of
//! inertia; D and M only add stiffness as s grows), so that one factorisation decides, and none but
//! Cholesky's is needed.

use nalgebra::{DMatrix, DVector, Dyn, SymmetricEigen};

use crate::rod::equations::boundary_conditions::TendonConstraint;
use crate::rod::equations::jacobian::Derivative;
use crate::rod::equations::system::RodEquations;
use crate::rod::state::rod::Rod;

/// Compliance assigned to an inextensible tendon, as a share of the compliance of the rod along it.
const MIN_COMPLIANCE_SHARE: f64 = 1e-6;
/// An eigenvalue above this, in units of the elastic stiffness, is not told from zero: a buckled
/// rod turns about the axis of its load as easily as the lateral load lets it.
pub(crate) const NEUTRAL_EIGENVALUE: f64 = 1e-5;
/// Iterations for an eigenvalue, per row.
const EIGEN_ITERATIONS: usize = 40;
/// Eigenvalues this close to the lowest one, in units of the elastic stiffness, belong to the same
/// loss of stability: a round rod buckles in any direction.
const EIGENVALUE_TOLERANCE: f64 = 1e-6;

/// K + s·D + s²·M, scaled so that the unloaded rod has a unit diagonal.
pub(crate) struct Tangent {
    pub(crate) matrix: DMatrix<f64>,
    /// Factor on each polynomial coefficient.
    scale: Vec<f64>,
}

impl Rod {
    /// The tangent at growth rate `rate` (1/s), from the derivative that the solver holds. D and M
    /// are those of the last derivative in motion.
    pub(crate) fn tangent(&self, constraints: &[TendonConstraint], rate: f64) -> Tangent {
        Tangent::new(&self.system, &self.solver.derivative, constraints, &self.state.taut, rate)
    }

    /// The tangent of a rest under `constraints` and the whole load at other `unknowns`; the solver
    /// stays as it is.
    pub(crate) fn tangent_at(&self, constraints: &[TendonConstraint], unknowns: &[f64]) -> Tangent {
        let Rod { system, state, motion, .. } = self;
        let loads = self.full_loads();
        let conditions = state.conditions(motion, constraints, &loads, true);
        let (mut workspace, mut derivative) = (system.workspace(), Derivative::new(system));
        system.evaluate(unknowns, &conditions, &mut workspace);
        derivative.update(system, unknowns, &conditions, &workspace);
        Tangent::new(system, &derivative, constraints, &state.taut, 0.0)
    }
}

impl Tangent {
    fn new(
        system: &RodEquations,
        derivative: &Derivative,
        constraints: &[TendonConstraint],
        taut: &[bool],
        rate: f64,
    ) -> Tangent {
        let (n, size) = (system.grid.unknowns, system.size());
        let bordered = &derivative.stiffness;
        // Moments and forces have different units; scaled, eigenvalues are shares of the stiffness.
        let scale: Vec<f64> = system.elastic_diagonal.iter().map(|k| k.sqrt().recip()).collect();
        let mut matrix = DMatrix::zeros(n, n);
        for row in 0..n {
            let factor = scale[row];
            let entries = bordered[row * size..row * size + n].iter().zip(&scale);
            let column = &mut matrix.as_mut_slice()[row * n..(row + 1) * n];
            column.iter_mut().zip(entries).for_each(|(entry, (k, s))| *entry = factor * s * k);
            if rate > 0.0 {
                let rates = derivative.rates.row(row).zip(&scale);
                column
                    .iter_mut()
                    .zip(rates)
                    .for_each(|(entry, ((d, m), s))| *entry += factor * s * rate * (d + rate * m));
            }
        }
        matrix.transpose_mut();
        for (i, constraint) in constraints.iter().enumerate() {
            if matches!(constraint, TendonConstraint::Length(_)) && taut[i] {
                let row = &bordered[(n + i) * size..(n + i) * size + n];
                // A taut tendon adds its stiffness along the change of its length.
                let pull = DVector::from_iterator(n, row.iter().zip(&scale).map(|(x, s)| x * s));
                let compliance = -bordered[(n + i) * size + n + i];
                let stiffness = 1.0
                    / compliance
                        .max(MIN_COMPLIANCE_SHARE * pull.norm_squared())
                        .max(f64::MIN_POSITIVE);
                matrix.ger(stiffness, &pull, &pull, 1.0);
            }
        }
        Tangent { matrix, scale }
    }

    /// Whether the symmetric part exceeds `margin` times the elastic stiffness in every direction.
    pub(crate) fn exceeds(&self, margin: f64) -> bool {
        let mut symmetric = self.symmetric();
        (0..symmetric.nrows()).for_each(|k| symmetric[(k, k)] -= margin);
        // Cholesky succeeds exactly for positive definite matrices and is far cheaper than
        // eigenvalues.
        symmetric.cholesky().is_some()
    }

    /// The directions, as changes of the polynomial coefficients, in which the energy falls
    /// fastest: one, or two where a rod buckles as easily in one direction as across it. Empty when
    /// no eigenvalue is negative or the iteration fails.
    pub(crate) fn descents(&self) -> Vec<Vec<f64>> {
        let Some(eigen) = self.eigen() else { return Vec::new() };
        let lowest = eigen.eigenvalues.min();
        if lowest >= -NEUTRAL_EIGENVALUE {
            return Vec::new();
        }
        let critical = (0..self.scale.len())
            .filter(|&index| eigen.eigenvalues[index] < lowest + EIGENVALUE_TOLERANCE);
        critical.map(|index| self.direction(&eigen, index)).collect()
    }

    /// The direction of the lowest eigenvalue, as a change of the polynomial coefficients.
    pub(crate) fn weakest(&self) -> Option<Vec<f64>> {
        let eigen = self.eigen()?;
        Some(self.direction(&eigen, eigen.eigenvalues.imin()))
    }

    fn eigen(&self) -> Option<SymmetricEigen<f64, Dyn>> {
        SymmetricEigen::try_new(self.symmetric(), f64::EPSILON, EIGEN_ITERATIONS * self.scale.len())
    }

    /// Eigenvector `index` as a change of the polynomial coefficients.
    fn direction(&self, eigen: &SymmetricEigen<f64, Dyn>, index: usize) -> Vec<f64> {
        eigen.eigenvectors.column(index).iter().zip(&self.scale).map(|(x, s)| x * s).collect()
    }

    /// The stiffness along a change of the polynomial coefficients.
    pub(crate) fn along(&self, direction: &[f64]) -> f64 {
        let scaled = DVector::from_iterator(
            direction.len(),
            direction.iter().zip(&self.scale).map(|(x, s)| x / s),
        );
        scaled.dot(&(&self.matrix * &scaled))
    }

    fn symmetric(&self) -> DMatrix<f64> {
        let mut symmetric = self.matrix.transpose();
        symmetric += &self.matrix;
        symmetric *= 0.5;
        symmetric
    }
}
