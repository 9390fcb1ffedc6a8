//! One static solve at a share of the loads.

use crate::rod::equations::boundary_conditions::{AppliedLoads, TendonConstraint};
use crate::rod::params::loads::TipWrench;
use crate::rod::solver::status::SolveStatus;
use crate::rod::state::rod::Rod;

/// Tip error allowed by the convergence criterion of a static solve (last step, squared for
/// Newton), metres.
const STATIC_TOLERANCE_M: f64 = 1e-8;

/// Newton iterations of a rod that may touch something, before its obstacles are softened.
const MAX_CONTACT_ITERATIONS: usize = 30;
/// Shares of the stiffness of obstacles while they harden.
const OBSTACLE_SHARES: [f64; 4] = [1e-3, 1e-2, 0.1, 1.0];

impl Rod {
    /// Static solve with all loads and pulls at `share` of their value.
    pub(crate) fn solve_static(
        &mut self,
        constraints: &[TendonConstraint],
        share: f64,
    ) -> SolveStatus {
        let (scaled, loads) = self.at_share(constraints, share);
        self.seed_tensions(&scaled);
        self.solve_at_rest(&scaled, &loads)
    }

    /// Solves for a rest. Where obstacles are in the way and Newton's method fails, they are soft
    /// at first and harden: it would start with a rod deep inside them.
    pub(super) fn solve_at_rest(
        &mut self,
        constraints: &[TendonConstraint],
        loads: &AppliedLoads,
    ) -> SolveStatus {
        if self.system.contact_points.is_empty() {
            return self.solve(constraints, loads, true, STATIC_TOLERANCE_M);
        }
        let max_iterations = self.solver.max_iterations;
        self.solver.max_iterations = max_iterations.min(MAX_CONTACT_ITERATIONS);
        let start = self.state.clone();
        let mut status = self.solve(constraints, loads, true, STATIC_TOLERANCE_M);
        if status != SolveStatus::Converged {
            self.state = start;
            // So soft that the rod would pass through, an obstacle is none.
            let passes = |share: &f64| self.system.softest_obstacle_share() > *share;
            let shares: Vec<f64> =
                OBSTACLE_SHARES.into_iter().filter(|share| !passes(share)).collect();
            for share in shares {
                self.obstacle_share = share;
                // The stiffness of the obstacles has changed.
                self.solver.discard_derivative();
                status = self.solve(constraints, loads, true, STATIC_TOLERANCE_M);
                if status != SolveStatus::Converged {
                    break;
                }
            }
            self.obstacle_share = 1.0;
        }
        self.solver.max_iterations = max_iterations;
        status
    }

    /// Evaluates the equations of a static solve at the present unknowns, and their derivative with
    /// D and M.
    pub(crate) fn refresh_static(&mut self, constraints: &[TendonConstraint], share: f64) {
        let (scaled, loads) = self.at_share(constraints, share);
        self.refresh(&scaled, &loads, true);
    }

    /// The commands and the loads at `share` of their value.
    fn at_share(
        &self,
        constraints: &[TendonConstraint],
        share: f64,
    ) -> (Vec<TendonConstraint>, AppliedLoads) {
        let scaled = |constraint: &TendonConstraint| match *constraint {
            TendonConstraint::Length(pull) => TendonConstraint::Length(share * pull),
            TendonConstraint::Tension(tension) => TendonConstraint::Tension(share * tension),
        };
        let tip = TipWrench {
            force_n: self.tip_load.force_n * share,
            moment_nm: self.tip_load.moment_nm * share,
        };
        let gravity_m_s2 = self.system.params.gravity_m_s2 * share;
        (constraints.iter().map(scaled).collect(), AppliedLoads { tip, share, gravity_m_s2 })
    }
}
