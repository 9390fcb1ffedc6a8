//! What Newton's method keeps between solves.

use nalgebra::{DVector, Dyn, LU};

use super::newton_damping::Damping;
use crate::rod::equations::jacobian::Derivative;
use crate::rod::equations::system::{System, Work};

const MOST_ITERATIONS: usize = 150;

/// Newton iteration with everything it keeps between solves.
#[derive(Clone, Debug)]
pub(crate) struct Solver {
    pub(crate) work: Work,
    pub(crate) derivative: Derivative,
    /// Factors of the derivative for the rates and taut sets it was last used with; the newest last.
    pub(super) factors: Vec<Factors>,
    /// What the derivative is good for.
    pub(super) kept: Kept,
    /// Whether the derivative is that of a shape beyond measure.
    pub(super) wild: bool,
    /// Whether the residual in `work` is that of the next solve's first iteration.
    pub(super) foretold: bool,
    /// Steps of the present solve since the derivative or the taut set changed.
    pub(super) steps: Vec<DVector<f64>>,
    /// What of a correction is taken of a rod that remembers.
    pub(super) damping: Damping,
    /// Size of the last step, metres: what the residual is worth at the tip.
    pub(crate) residual_m: f64,
    /// Iterations after which a solve is given up.
    pub(crate) patience: usize,
    /// Iterations since construction.
    pub(crate) iterations: u64,
    /// Derivatives since construction.
    pub(crate) derivatives: u64,
    /// Factorisations since construction.
    pub(crate) factorisations: u64,
}

/// What a derivative is good for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kept {
    Nothing,
    Rest,
    Motion,
}

/// The factorised derivative for one rate and taut set.
#[derive(Clone, Debug)]
pub(super) struct Factors {
    pub(super) rate: f64,
    pub(super) taut: Vec<bool>,
    pub(super) lu: LU<f64, Dyn, Dyn>,
}

impl Solver {
    pub(crate) fn new(system: &System) -> Solver {
        Solver {
            work: system.work(),
            derivative: Derivative::new(system),
            factors: Vec::new(),
            kept: Kept::Nothing,
            wild: false,
            foretold: false,
            steps: Vec::new(),
            damping: Damping::new(),
            residual_m: 0.0,
            patience: MOST_ITERATIONS,
            iterations: 0,
            derivatives: 0,
            factorisations: 0,
        }
    }

    /// Makes the next solve begin with a new derivative.
    pub(crate) fn forget(&mut self) {
        self.kept = Kept::Nothing;
    }
}
