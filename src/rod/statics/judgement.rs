//! Whether a rod would stay in an equilibrium.

use crate::rod::equations::boundary_conditions::TendonConstraint;
use crate::rod::solver::status::SolveStatus;
use crate::rod::stability::linearised_motion::{Growth, all_positive};
use crate::rod::stability::tangent::NEUTRAL;
use crate::rod::state::rod::Rod;

/// What becomes of small deviations from an equilibrium.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Stability {
    /// They vanish.
    Stable,
    /// They grow along these directions (changes of the polynomial coefficients).
    Unstable(Vec<Vec<f64>>),
    /// They grow as oscillations.
    Flutters,
}

impl Rod {
    /// Judges the equilibrium under `holds` that the rod is in. A conservative rod is stable where the tangent is positive
    /// definite. Follower loads, which have no potential, are judged by the linearised motion; a dead moment, which has
    /// none either, by the eigenvalues of the tangent where its symmetric part is not positive definite.
    pub(crate) fn judge(&mut self, holds: &[TendonConstraint]) -> Stability {
        self.solver.forget();
        if self.solve_static(holds, 1.0) != SolveStatus::Converged {
            return Stability::Stable;
        }
        if self.has_follower_loads() {
            self.refresh_static(holds, 1.0);
            return match self.growth(holds) {
                Some(Growth::None) => Stability::Stable,
                Some(Growth::Flutter(_)) => Stability::Flutters,
                // A rod without mass, or one whose eigenvalues were not found.
                None if all_positive(self.tangent(holds, 0.0).matrix) => Stability::Stable,
                Some(Growth::Divergence(_)) | None => Stability::Unstable(self.tangent(holds, 0.0).descents()),
            };
        }
        let tangent = self.tangent(holds, 0.0);
        if tangent.exceeds(-NEUTRAL) {
            return Stability::Stable;
        }
        let descents = tangent.descents();
        if descents.is_empty() || all_positive(tangent.matrix) {
            Stability::Stable
        } else {
            Stability::Unstable(descents)
        }
    }
}
