//! Is the grid fine enough? Static solves that refine cells and polynomials until the estimate of what the
//! discretisation in space puts the tip off by is small enough (docs/robustness.md).

use crate::rod::discretisation::levels::MOST_REFINEMENTS;
use crate::rod::equations::boundary_conditions::TendonConstraint;
use crate::rod::equations::shape::distance_m;
use crate::rod::solver::status::SolveStatus;
use crate::rod::state::rod::Rod;

/// Newton iterations from one grid to the next.
const MAX_ITERATIONS: usize = 40;
/// Shapes on two grids that lie further apart than this share of the length may be two equilibria.
const ANOTHER: f64 = 1e-3;
/// A rod whose material remembers has fronts where it yields, kinks that no polynomial resolves: such rods are held to
/// this many times the tolerance.
const MEMORY_TOLERANCE: f64 = 100.0;

impl Rod {
    /// Judges a shape at rest that solves the equations under `holds`: is it possible, does a finer grid agree?
    /// Refines until the grid is fine enough; a rod whose shape is refused goes back to the grid that it had.
    pub(crate) fn verify_equilibrium(&mut self, holds: &[TendonConstraint]) -> SolveStatus {
        let status = self.leave_if_unstable(holds);
        if status != SolveStatus::Converged {
            return status;
        }
        let share = if self.system.params.moment_laws.is_empty() { 1.0 } else { MEMORY_TOLERANCE };
        let tolerance_m = share * self.grid_level.base.static_tolerance_m;
        let mut estimate = self.estimate();
        if estimate.cautious_m() > tolerance_m && self.solve_static(holds, 1.0) == SolveStatus::Converged {
            // The last iteration left an imbalance of its own; one more does not.
            estimate = self.estimate();
        }
        self.grid_level.error_m = estimate.cautious_m();
        self.confirm_by_reconstruction(holds, tolerance_m, estimate.plain_m());
        if self.grid_level.error_m <= tolerance_m {
            return self.check_interpenetration();
        }
        let mut fallback = None;
        let mut status = SolveStatus::UnderResolved;
        while self.grid_level.error_m > tolerance_m && self.grid_level.level < MOST_REFINEMENTS {
            let mut finer = self.on_grid(self.grid_level.level + 1);
            let max_iterations = std::mem::replace(&mut finer.solver.max_iterations, MAX_ITERATIONS);
            status = finer.solve_static(holds, 1.0);
            finer.solver.max_iterations = max_iterations;
            // Of what polynomials that end at every jump leave, the reconstruction misses nothing.
            let estimate = finer.estimate();
            finer.grid_level.error_m = if finer.grid_level.level > 1 { 0.0 } else { estimate.cautious_m() };
            finer.confirm_by_reconstruction(holds, tolerance_m, estimate.plain_m());
            let hopeless = finer.grid_level.level > 1 && finer.grid_level.error_m > self.system.params.length_m();
            let coarser = std::mem::replace(self, finer);
            fallback.get_or_insert(coarser);
            if status != SolveStatus::Converged || hopeless {
                // The coarse answer stands unconfirmed.
                status = SolveStatus::UnderResolved;
                break;
            }
        }
        if status == SolveStatus::Converged {
            let settled = self.grid_level.error_m <= tolerance_m;
            status = if settled { self.verify_stability(holds, fallback.as_ref()) } else { SolveStatus::UnderResolved };
        }
        if let (true, Some(mut coarse)) = (status != SolveStatus::Converged, fallback) {
            coarse.grid_level.error_m = self.grid_level.error_m;
            *self = coarse;
        }
        status
    }

    /// A finer grid may have led to another equilibrium than that of `coarse`, which was a stable one.
    fn verify_stability(&mut self, holds: &[TendonConstraint], coarse: Option<&Rod>) -> SolveStatus {
        let length_m = self.system.params.length_m();
        let elsewhere = coarse
            .is_some_and(|coarse| distance_m(&coarse.state.shape, &self.state.shape, length_m) > ANOTHER * length_m);
        if elsewhere && !self.is_stable_by_bound() && self.unstable_direction(holds).is_some() {
            return SolveStatus::Unstable;
        }
        self.check_interpenetration()
    }
}
