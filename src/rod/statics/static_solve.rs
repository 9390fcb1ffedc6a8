//! One static solve at a share of the loads.

use crate::rod::equations::boundary_conditions::TendonConstraint;
use crate::rod::params::loads::TipWrench;
use crate::rod::solver::status::SolveStatus;
use crate::rod::state::rod::Rod;

/// Tip error allowed by the convergence criterion of a static solve (last step, squared for Newton), metres.
const STATIC_TOLERANCE_M: f64 = 1e-8;

impl Rod {
    /// Static solve with all loads and pulls at `share` of their value.
    pub(crate) fn solve_static(&mut self, holds: &[TendonConstraint], share: f64) -> SolveStatus {
        let scaled: Vec<TendonConstraint> = holds
            .iter()
            .map(|hold| match *hold {
                TendonConstraint::Length(pull) => TendonConstraint::Length(share * pull),
                TendonConstraint::Tension(tension) => TendonConstraint::Tension(share * tension),
            })
            .collect();
        let load = TipWrench { force_n: self.tip_load.force_n * share, moment_nm: self.tip_load.moment_nm * share };
        self.seed_tensions(&scaled);
        let gravity = self.system.params.gravity_m_s2 * share;
        self.solve(&scaled, (&load, share), gravity, true, STATIC_TOLERANCE_M)
    }
}
