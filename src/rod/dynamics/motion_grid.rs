//! The grid of a motion.

use crate::rod::equations::shape::distance_m;
use crate::rod::solver::status::SolveStatus;
use crate::rod::state::rod::Rod;

/// A motion keeps the refined grid of the equilibrium that it starts from if the equilibrium on the
/// requested grid is farther away than this share of the length: the rod would move from one to the
/// other with nothing moving it.
const DRIFT_SHARE: f64 = 2e-3;
/// Refined grids with more unknowns than this are never kept: a motion on them takes minutes.
/// Helices of several turns need 90 to 140.
const MAX_UNKNOWNS: usize = 200;

impl Rod {
    /// Motions use the requested grid, not the refined grid of an equilibrium, unless that
    /// displaces the equilibrium. A refined grid is kept to the next equilibrium.
    pub(crate) fn choose_motion_grid(&mut self) {
        if self.grid_level.level == 0 || self.settled_under.is_none() {
            return;
        }
        let is_large = self.system.grid.unknowns > MAX_UNKNOWNS;
        if is_large || self.drift_m() <= DRIFT_SHARE * self.system.params.length_m() {
            self.coarsen();
        }
    }

    /// Distance from the present equilibrium to that on the requested grid, metres; 0 if there is
    /// none, and for rods with histories, whose equilibria are not unique.
    fn drift_m(&self) -> f64 {
        let Some(rest) =
            self.settled_under.as_ref().filter(|_| self.system.params.moment_laws.is_empty())
        else {
            return 0.0;
        };
        // A trial on a copy: the rod itself keeps its grid unless both agree.
        let mut coarse = self.on_grid(0);
        match coarse.solve_static(&rest.constraints, 1.0) {
            SolveStatus::Converged => {
                distance_m(&coarse.state.shape, &self.state.shape, self.system.params.length_m())
            }
            _ => 0.0,
        }
    }
}
