//! Adaptive refinement of static solves: cells and polynomials are added until the estimated tip
//! error is below the tolerance (docs/method/robustness.md).

use crate::rod::discretisation::levels::MAX_REFINEMENTS;
use crate::rod::equations::boundary_conditions::TendonConstraint;
use crate::rod::equations::shape::distance_m;
use crate::rod::params::tendon::Tendon;
use crate::rod::solver::status::SolveStatus;
use crate::rod::state::rod::Rod;
use crate::rod::statics::judgement::Stability;

use super::stable_branch::RestBefore;

/// Newton iterations after a change of grid.
const MAX_ITERATIONS: usize = 40;
/// Tip distance between two grids, as a share of the length, beyond which the equilibria may
/// differ.
const SAME_EQUILIBRIUM_LENGTHS: f64 = 1e-3;
/// Tolerance factor where the wrench has kinks that no polynomial resolves: at the yield fronts of
/// history-dependent moments, at contacts, and where a tendon with friction turns the other way.
const KINK_TOLERANCE: f64 = 100.0;

impl Rod {
    /// Verifies an equilibrium under `constraints`: stability, interpenetration and discretisation
    /// error. Refines the grid as needed. On failure the rod returns to its previous grid.
    pub(crate) fn verify_equilibrium(
        &mut self,
        constraints: &[TendonConstraint],
        before: &RestBefore,
    ) -> SolveStatus {
        let stability = self.find_stable_rest(constraints, before);
        if !stability.is_equilibrium() {
            return stability;
        }
        let params = &self.system.params;
        let smooth = params.moment_laws.is_empty()
            && !params.tendons.iter().any(Tendon::has_friction)
            && self.solver.workspace.touches.is_empty();
        let share = if smooth { 1.0 } else { KINK_TOLERANCE };
        let tolerance_m = share * self.grid_level.base.static_tolerance_m;
        let mut estimate = self.estimate();
        if estimate.cautious_m() > tolerance_m
            && self.solve_static(constraints, 1.0) == SolveStatus::Converged
        {
            // One more iteration removes the imbalance that the last one left.
            estimate = self.estimate();
        }
        self.grid_level.error_m = estimate.cautious_m();
        self.confirm_by_reconstruction(constraints, tolerance_m, estimate.plain_m());
        if self.grid_level.error_m <= tolerance_m {
            return self.check_interpenetration().or(stability);
        }
        // The first, coarsest rod is kept: a motion goes on from it if refinement fails.
        let mut fallback = None;
        let mut status = SolveStatus::UnderResolved;
        while self.grid_level.error_m > tolerance_m && self.grid_level.level < MAX_REFINEMENTS {
            let mut finer = self.on_grid(self.grid_level.level + 1);
            let max_iterations =
                std::mem::replace(&mut finer.solver.max_iterations, MAX_ITERATIONS);
            status = finer.solve_static(constraints, 1.0);
            finer.solver.max_iterations = max_iterations;
            // With elements that end at every jump the reconstruction captures the whole error.
            let estimate = finer.estimate();
            finer.grid_level.error_m =
                if finer.grid_level.level > 1 { 0.0 } else { estimate.cautious_m() };
            finer.confirm_by_reconstruction(constraints, tolerance_m, estimate.plain_m());
            // An error of a whole length will not shrink to the tolerance in two more levels.
            let hopeless = finer.grid_level.level > 1
                && finer.grid_level.error_m > self.system.params.length_m();
            let coarser = std::mem::replace(self, finer);
            fallback.get_or_insert(coarser);
            if status != SolveStatus::Converged || hopeless {
                // The coarse solution remains unconfirmed.
                status = SolveStatus::UnderResolved;
                break;
            }
        }
        if status == SolveStatus::Converged {
            let resolved = self.grid_level.error_m <= tolerance_m;
            status = if resolved {
                self.verify_stability(constraints, fallback.as_ref())
            } else {
                SolveStatus::UnderResolved
            };
        }
        if let (true, Some(mut coarse)) = (status != SolveStatus::Converged, fallback) {
            coarse.grid_level.error_m = self.grid_level.error_m;
            *self = coarse;
        }
        status.or(stability)
    }

    /// Checks that refinement has not led from the stable equilibrium of `coarse` to an unstable
    /// one.
    fn verify_stability(
        &mut self,
        constraints: &[TendonConstraint],
        coarse: Option<&Rod>,
    ) -> SolveStatus {
        let length_m = self.system.params.length_m();
        let is_distant = coarse.is_some_and(|coarse| {
            distance_m(&coarse.state.shape, &self.state.shape, length_m)
                > SAME_EQUILIBRIUM_LENGTHS * length_m
        });
        if is_distant
            && !self.is_stable_by_bound()
            && matches!(self.judge(constraints), Stability::Unstable(_))
        {
            return SolveStatus::Unstable;
        }
        self.check_interpenetration()
    }
}
