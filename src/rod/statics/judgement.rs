//! Whether a rod would stay in an equilibrium.

use crate::rod::equations::boundary_conditions::TendonConstraint;
use crate::rod::solver::status::SolveStatus;
use crate::rod::stability::linearised_motion::{Growth, all_positive};
use crate::rod::stability::tangent::NEUTRAL_EIGENVALUE;
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
    /// Judges the equilibrium under `constraints` that the rod is in. A conservative rod is stable
    /// where the tangent is positive definite. Follower loads, which have no potential, are judged
    /// by the linearised motion; a dead moment, which has none either, by the eigenvalues of the
    /// tangent where its symmetric part is not positive definite.
    pub(crate) fn judge(&mut self, constraints: &[TendonConstraint]) -> Stability {
        // The verdict needs the derivative at the solution, not near it.
        self.solver.discard_derivative();
        if self.solve_static(constraints, 1.0) != SolveStatus::Converged {
            return Stability::Stable;
        }
        if self.has_follower_loads() {
            self.refresh_static(constraints, 1.0);
            return match self.growth(constraints) {
                Some(Growth::None) => Stability::Stable,
                Some(Growth::Flutter(_)) => Stability::Flutters,
                // A rod without mass, or one whose eigenvalues were not found.
                None if all_positive(self.tangent(constraints, 0.0).matrix) => Stability::Stable,
                Some(Growth::Divergence(_)) | None => {
                    Stability::Unstable(self.tangent(constraints, 0.0).descents())
                }
            };
        }
        let tangent = self.tangent(constraints, 0.0);
        if tangent.exceeds(-NEUTRAL_EIGENVALUE) {
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
