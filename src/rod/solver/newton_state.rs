//! What Newton's method keeps between solves.

use nalgebra::{DVector, Dyn, LU};

use super::newton_damping::NewtonDamping;
use crate::rod::equations::jacobian::Derivative;
use crate::rod::equations::system::{RodEquations, Workspace};

const MOST_ITERATIONS: usize = 150;

/// Newton iteration with everything it keeps between solves.
#[derive(Clone, Debug)]
pub(crate) struct NewtonSolver {
    pub(crate) workspace: Workspace,
    pub(crate) derivative: Derivative,
    /// Factors of the derivative for the rates and taut sets it was last used with; the newest last.
    pub(super) factors: Vec<LuFactors>,
    /// What the derivative is good for.
    pub(super) kept: DerivativeUse,
    /// Whether the derivative is that of a shape beyond measure.
    pub(super) unreliable: bool,
    /// Whether the residual in `workspace` is that of the next solve's first iteration.
    pub(super) residual_predicted: bool,
    /// Steps of the present solve since the derivative or the taut set changed.
    pub(super) steps: Vec<DVector<f64>>,
    /// What of a correction is taken of a rod that remembers.
    pub(super) damping: NewtonDamping,
    /// Size of the last step, metres: what the residual is worth at the tip.
    pub(crate) residual_m: f64,
    /// Iterations after which a solve is given up.
    pub(crate) max_iterations: usize,
    /// Iterations since construction.
    pub(crate) iterations: u64,
    /// Derivatives since construction.
    pub(crate) derivatives: u64,
    /// Factorisations since construction.
    pub(crate) factorisations: u64,
}

/// What a derivative is good for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum DerivativeUse {
    Nothing,
    Rest,
    Motion,
}

/// The factorised derivative for one rate and taut set.
#[derive(Clone, Debug)]
pub(super) struct LuFactors {
    pub(super) rate: f64,
    pub(super) taut: Vec<bool>,
    pub(super) lu: LU<f64, Dyn, Dyn>,
}

impl NewtonSolver {
    pub(crate) fn new(system: &RodEquations) -> NewtonSolver {
        NewtonSolver {
            workspace: system.workspace(),
            derivative: Derivative::new(system),
            factors: Vec::new(),
            kept: DerivativeUse::Nothing,
            unreliable: false,
            residual_predicted: false,
            steps: Vec::new(),
            damping: NewtonDamping::new(),
            residual_m: 0.0,
            max_iterations: MOST_ITERATIONS,
            iterations: 0,
            derivatives: 0,
            factorisations: 0,
        }
    }

    /// Makes the next solve begin with a new derivative.
    pub(crate) fn forget(&mut self) {
        self.kept = DerivativeUse::Nothing;
    }
}
