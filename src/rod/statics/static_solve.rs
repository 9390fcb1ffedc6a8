//! One static solve at a share of the loads.

use crate::rod::equations::boundary_conditions::TendonConstraint;
use crate::rod::params::loads::TipWrench;
use crate::rod::solver::status::SolveStatus;
use crate::rod::state::rod::Rod;

/// Tip error allowed by the convergence criterion of a static solve (last step, squared for Newton), metres.
pub(super) const STATIC_TOLERANCE_M: f64 = 1e-8;

impl Rod {
    /// Static solve with all loads and pulls at `share` of their value.
    pub(crate) fn solve_static(&mut self, holds: &[TendonConstraint], share: f64) -> SolveStatus {
        let (scaled, load) = self.at_share(holds, share);
        self.seed_tensions(&scaled);
        let gravity = self.system.params.gravity_m_s2 * share;
        self.solve(&scaled, (&load, share), gravity, true, STATIC_TOLERANCE_M)
    }

    /// Evaluates the equations of a static solve at the present unknowns, and their derivative with D and M.
    pub(crate) fn refresh_static(&mut self, holds: &[TendonConstraint], share: f64) {
        let (scaled, load) = self.at_share(holds, share);
        let gravity = self.system.params.gravity_m_s2 * share;
        self.refresh(&scaled, (&load, share), gravity, true);
    }

    /// The commands and the load of the tip at `share` of their value.
    fn at_share(&self, holds: &[TendonConstraint], share: f64) -> (Vec<TendonConstraint>, TipWrench) {
        let scaled = |hold: &TendonConstraint| match *hold {
            TendonConstraint::Length(pull) => TendonConstraint::Length(share * pull),
            TendonConstraint::Tension(tension) => TendonConstraint::Tension(share * tension),
        };
        let load = TipWrench { force_n: self.tip_load.force_n * share, moment_nm: self.tip_load.moment_nm * share };
        (holds.iter().map(scaled).collect(), load)
    }
}
