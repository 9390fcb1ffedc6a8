//! Check of the discretisation error of a moving rod.

use crate::rod::solver::status::SolveStatus;
use crate::rod::state::rod::Rod;

/// Estimated tip error, as a share of the length, beyond which a moving rod is under-resolved:
/// there the waves that run along it are shorter than the polynomials (docs/method/robustness.md).
const MAX_ERROR_SHARE: f64 = 0.05;

impl Rod {
    /// Verifies the shape of a moving rod; its grid does not change. The viscous stiffness reduces
    /// the effect of an imbalance.
    pub(crate) fn verify_motion(&mut self) -> SolveStatus {
        let stiffening = 1.0 + self.motion.rate * self.system.params.damping_time_s;
        let estimate = self.estimate();
        let error_m = estimate.cells_m + estimate.balance_m / stiffening;
        // NaN must not count as small.
        self.grid_level.error_m = if error_m.is_finite() { error_m } else { f64::INFINITY };
        if self.grid_level.error_m > MAX_ERROR_SHARE * self.system.params.length_m() {
            return SolveStatus::UnderResolved;
        }
        self.check_interpenetration()
    }
}
