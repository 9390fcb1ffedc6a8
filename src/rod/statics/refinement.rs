//! Is the grid fine enough? Static solves that refine cells and polynomials until the estimate of what the
//! discretisation in space puts the tip off by is small enough (docs/robustness.md).

use crate::rod::discretisation::levels::MOST_REFINEMENTS;
use crate::rod::equations::boundary_conditions::Hold;
use crate::rod::equations::shape::distance_m;
use crate::rod::solver::status::Status;
use crate::rod::state::rod::Rod;

/// Newton iterations from one grid to the next.
const PATIENCE: usize = 40;
/// Shapes on two grids that lie further apart than this share of the length may be two equilibria.
const ANOTHER: f64 = 1e-3;
/// A rod whose material remembers has fronts where it yields, kinks that no polynomial resolves: such rods are held to
/// this many times the tolerance.
const MEMORY_TOLERANCE: f64 = 100.0;

impl Rod {
    /// Judges a shape at rest that solves the equations under `holds`: is it possible, does a finer grid agree?
    /// Refines until the grid is fine enough; a rod whose shape is refused goes back to the grid that it had.
    pub(crate) fn examine_rest(&mut self, holds: &[Hold]) -> Status {
        let status = self.leave_if_unstable(holds);
        if status != Status::Converged {
            return status;
        }
        let share = if self.system.params.memory.is_empty() { 1.0 } else { MEMORY_TOLERANCE };
        let tolerance_m = share * self.space.base.static_tolerance_m;
        let mut estimate = self.estimate();
        if estimate.cautious_m() > tolerance_m && self.solve_static(holds, 1.0) == Status::Converged {
            // The last iteration left an imbalance of its own; one more does not.
            estimate = self.estimate();
        }
        self.space.error_m = estimate.cautious_m();
        self.confirm(holds, tolerance_m, estimate.plain_m());
        if self.space.error_m <= tolerance_m {
            return self.possible();
        }
        let mut fallback = None;
        let mut status = Status::UnderResolved;
        while self.space.error_m > tolerance_m && self.space.level < MOST_REFINEMENTS {
            let mut finer = self.on_grid(self.space.level + 1);
            let patience = std::mem::replace(&mut finer.solver.patience, PATIENCE);
            status = finer.solve_static(holds, 1.0);
            finer.solver.patience = patience;
            // Of what polynomials that end at every jump leave, the reconstruction misses nothing.
            let estimate = finer.estimate();
            finer.space.error_m = if finer.space.level > 1 { 0.0 } else { estimate.cautious_m() };
            finer.confirm(holds, tolerance_m, estimate.plain_m());
            let hopeless = finer.space.level > 1 && finer.space.error_m > self.system.params.length_m();
            let coarser = std::mem::replace(self, finer);
            fallback.get_or_insert(coarser);
            if status != Status::Converged || hopeless {
                // The coarse answer stands unconfirmed.
                status = Status::UnderResolved;
                break;
            }
        }
        if status == Status::Converged {
            let settled = self.space.error_m <= tolerance_m;
            status = if settled { self.still_stable(holds, fallback.as_ref()) } else { Status::UnderResolved };
        }
        if let (true, Some(mut coarse)) = (status != Status::Converged, fallback) {
            coarse.space.error_m = self.space.error_m;
            *self = coarse;
        }
        status
    }

    /// A finer grid may have led to another equilibrium than that of `coarse`, which was a stable one.
    fn still_stable(&mut self, holds: &[Hold], coarse: Option<&Rod>) -> Status {
        let length_m = self.system.params.length_m();
        let elsewhere = coarse
            .is_some_and(|coarse| distance_m(&coarse.state.shape, &self.state.shape, length_m) > ANOTHER * length_m);
        if elsewhere && !self.certainly_stable() && self.unstable_direction(holds).is_some() {
            return Status::Unstable;
        }
        self.possible()
    }
}
