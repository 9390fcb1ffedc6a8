//! Is the grid fine enough for the shape of a moving rod?

use crate::rod::solver::status::SolveStatus;
use crate::rod::state::rod::Rod;

/// Share of the length that the estimate may say a moving rod's tip is off by before its answer is refused.
const MOTION_BOUND: f64 = 0.05;

impl Rod {
    /// Judges the shape of a moving rod, whose grid stays as it is. What is missing in the balance meets the viscous
    /// stiffness as well.
    pub(crate) fn verify_motion(&mut self) -> SolveStatus {
        let stiffer = 1.0 + self.motion.rate * self.system.params.damping_time_s;
        let estimate = self.estimate();
        let error_m = estimate.cells_m + estimate.balance_m / stiffer;
        self.grid_level.error_m = if error_m.is_finite() { error_m } else { f64::INFINITY };
        if self.grid_level.error_m > MOTION_BOUND * self.system.params.length_m() {
            return SolveStatus::UnderResolved;
        }
        self.check_interpenetration()
    }
}
