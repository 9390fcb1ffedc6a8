//! Continuation in the loads: static solves from no load to the full one.

use crate::rod::equations::boundary_conditions::TendonConstraint;
use crate::rod::solver::status::SolveStatus;
use crate::rod::state::rod::Rod;

/// Smallest load increment before dynamic relaxation takes over.
const MIN_INCREMENT: f64 = 0.02;
/// Iterations after which continuation tries a smaller share.
const MAX_CONTINUATION_ITERATIONS: usize = 50;

impl Rod {
    /// Raises all loads from zero, in increments that shrink on failure and grow on success.
    pub(crate) fn continue_in_load(&mut self, constraints: &[TendonConstraint]) -> SolveStatus {
        self.state.unknowns.fill(0.0);
        self.state.taut.fill(false);
        // A stuck share is better tried smaller than iterated longer.
        let max_iterations =
            std::mem::replace(&mut self.solver.max_iterations, MAX_CONTINUATION_ITERATIONS);
        let status = self.raise_load(constraints);
        self.solver.max_iterations = max_iterations;
        status
    }

    fn raise_load(&mut self, constraints: &[TendonConstraint]) -> SolveStatus {
        let (mut reached_share, mut increment) = (0.0, 0.25);
        while reached_share < 1.0 {
            let target = f64::min(reached_share + increment, 1.0);
            let saved = self.state.clone();
            match self.solve_static(constraints, target) {
                SolveStatus::Converged => {
                    reached_share = target;
                    increment *= 1.5;
                }
                failure => {
                    self.state = saved;
                    increment *= 0.35;
                    if increment < MIN_INCREMENT {
                        return failure;
                    }
                }
            }
        }
        SolveStatus::Converged
    }
}
