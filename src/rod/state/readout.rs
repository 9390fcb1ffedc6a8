//! What a rod shows of itself: its tip, its tendons and the work of the solver.

use nalgebra::{Matrix3, Vector3};

use super::rod::Rod;
use crate::rod::solver::newton_state::NewtonSolver;

/// What solving has taken so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Time steps, those that had to be repeated not counted.
    pub steps: u64,
    /// Evaluations of the equations, one an iteration.
    pub iterations: u64,
    /// Evaluations of their derivative.
    pub derivatives: u64,
    /// Factorisations of it.
    pub factorisations: u64,
}

impl Rod {
    /// Tip position in the world frame, metres.
    pub fn tip_m(&self) -> Vector3<f64> {
        self.state.shape.tip_m()
    }

    /// Tip orientation, columns are the body axes.
    pub fn tip_rotation(&self) -> Matrix3<f64> {
        self.state.shape.tip_rotation()
    }

    /// Position (metres) and orientation of the cross-section `position_m` from the base along the relaxed rod, world
    /// frame; the nearest end where the rod has no such place.
    pub fn pose_at(&self, position_m: f64) -> (Vector3<f64>, Matrix3<f64>) {
        self.state.shape.pose_at(&self.system.grid, position_m)
    }

    /// Tendon tensions, N; 0 when slack.
    pub fn tensions_n(&self) -> &[f64] {
        &self.state.unknowns[self.system.grid.unknowns..]
    }

    /// Displacement at which each tendon would be neither slack nor under tension, metres.
    pub fn following_pulls_m(&self) -> Vec<f64> {
        let lengths_m = self.system.lengths_m(&self.state.shape);
        let homes = lengths_m.iter().zip(&self.system.home_lengths_m);
        homes.zip(&self.system.params.tendons).map(|((now, home), t)| home - now - t.pretension_m).collect()
    }

    /// What the last solve may be off by at the tip, metres.
    pub fn residual_m(&self) -> f64 {
        self.solver.residual_m
    }

    /// Work done so far.
    pub fn effort(&self) -> Effort {
        let NewtonSolver { iterations, derivatives, factorisations, .. } = self.solver;
        Effort { steps: self.step_size.taken, iterations, derivatives, factorisations }
    }
}
