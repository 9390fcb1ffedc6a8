//! State of Newton's method between solves.

use nalgebra::{DVector, Dyn, LU};

use super::newton_damping::NewtonDamping;
use crate::rod::equations::jacobian::Derivative;
use crate::rod::equations::system::{RodEquations, Workspace};
use crate::rod::params::loads::TipWrench;

/// Iteration limit of a solve, unless its caller sets a lower one.
const MAX_ITERATIONS: usize = 150;

/// The Newton solver with its buffers and factors.
#[derive(Clone, Debug)]
pub(crate) struct NewtonSolver {
    pub(crate) workspace: Workspace,
    pub(crate) derivative: Derivative,
    /// LU factors by rate and taut set; the most recent last.
    pub(super) factors: Vec<LuFactors>,
    /// Problem type that the derivative was computed for.
    pub(super) derivative_use: DerivativeUse,
    /// Whether the derivative was taken at an extreme imbalance and must not be reused.
    pub(super) unreliable: bool,
    /// Whether the residual in `workspace` is that of the next solve's first iteration.
    pub(super) residual_predicted: bool,
    /// Contacts of the derivative.
    pub(super) contact_set: Vec<(usize, usize)>,
    /// Load at the tip under which the derivative was computed.
    pub(crate) differentiated_under: TipWrench,
    /// The last derivative that proved stability.
    stable: Option<StableDerivative>,
    /// Steps of the present solve since the derivative or the taut set changed.
    pub(super) steps: Vec<DVector<f64>>,
    /// Damping for rods with history-dependent moments.
    pub(super) damping: NewtonDamping,
    /// Estimated tip error of the last solve, metres.
    pub(crate) residual_m: f64,
    /// Iteration limit of one solve.
    pub(crate) max_iterations: usize,
    /// Iterations since construction.
    pub(crate) iterations: u64,
    /// Derivatives since construction.
    pub(crate) derivatives: u64,
    /// Factorisations since construction.
    pub(crate) factorisations: u64,
}

/// Problem type of a derivative.
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

/// A derivative whose tangent is positive definite by a margin, for one taut set.
#[derive(Clone, Debug, PartialEq)]
struct StableDerivative {
    /// Its number, by the count of derivatives.
    number: u64,
    taut: Vec<bool>,
}

impl NewtonSolver {
    pub(crate) fn new(system: &RodEquations) -> NewtonSolver {
        NewtonSolver {
            workspace: system.workspace(),
            derivative: Derivative::new(system),
            factors: Vec::new(),
            derivative_use: DerivativeUse::Nothing,
            unreliable: false,
            residual_predicted: false,
            contact_set: Vec::new(),
            differentiated_under: TipWrench::default(),
            stable: None,
            steps: Vec::new(),
            damping: NewtonDamping::new(),
            residual_m: 0.0,
            max_iterations: MAX_ITERATIONS,
            iterations: 0,
            derivatives: 0,
            factorisations: 0,
        }
    }

    /// Whether the present derivative has proved stability for this taut set.
    pub(crate) fn is_stable_derivative(&self, taut: &[bool]) -> bool {
        self.stable
            .as_ref()
            .is_some_and(|stable| stable.number == self.derivatives && stable.taut == taut)
    }

    /// Records that the present derivative proves stability for this taut set.
    pub(crate) fn mark_derivative_stable(&mut self, taut: &[bool]) {
        self.stable = Some(StableDerivative { number: self.derivatives, taut: taut.to_vec() });
    }

    /// Forces the next solve to recompute the derivative.
    pub(crate) fn discard_derivative(&mut self) {
        self.derivative_use = DerivativeUse::Nothing;
    }
}
