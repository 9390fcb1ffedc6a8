//! Quantities read from a rod: tip, tendons, solver statistics.

use nalgebra::{Matrix3, Vector3};

use super::branch::RestBranch;
use super::rod::Rod;
use crate::rod::equations::contact::{ContactSum, HomePenetration};
use crate::rod::equations::system::RodEquations;
use crate::rod::params::rod_params::RodParams;
use crate::rod::solver::newton_state::NewtonSolver;

/// Solver statistics since construction or restart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Accepted time steps.
    pub steps: u64,
    /// Evaluations of the residual, one per iteration.
    pub iterations: u64,
    /// Evaluations of the derivative.
    pub derivatives: u64,
    /// Factorisations of the derivative.
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

    /// Position (metres) and orientation of the cross-section at arc length `position_m`, world
    /// frame; clamped to the ends of the rod.
    pub fn pose_at(&self, position_m: f64) -> (Vector3<f64>, Matrix3<f64>) {
        self.state.shape.pose_at(&self.system.grid, position_m)
    }

    /// Tendon tensions, N; 0 when slack.
    pub fn tensions_n(&self) -> &[f64] {
        &self.state.unknowns[self.system.grid.unknowns..]
    }

    /// Displacement at which each tendon is just taut without tension, metres.
    pub fn following_pulls_m(&self) -> Vec<f64> {
        let lengths_m = self.system.lengths_m(&self.state.shape);
        let homes = lengths_m.iter().zip(&self.system.home_lengths_m);
        homes
            .zip(&self.system.params.tendons)
            .map(|((now, home), tendon)| home - now - tendon.pretension_m)
            .collect()
    }

    /// How the last equilibrium is connected with the one before.
    pub fn branch(&self) -> RestBranch {
        self.branch
    }

    /// The obstacle that reaches deepest into the unloaded rod of `params`; `None` where all are
    /// outside.
    pub fn touched_at_home(params: &RodParams) -> Option<HomePenetration> {
        if params.contact.obstacles.is_empty() {
            return None;
        }
        RodEquations::new(params.clone()).home_penetration()
    }

    /// All contacts with obstacles together; `None` where the rod touches nothing.
    pub fn contact(&self) -> Option<ContactSum> {
        ContactSum::of(&self.solver.workspace.touches)
    }

    /// Estimated tip error of the last solve, metres.
    pub fn residual_m(&self) -> f64 {
        self.solver.residual_m
    }

    /// Solver statistics so far.
    pub fn effort(&self) -> Effort {
        let NewtonSolver { iterations, derivatives, factorisations, .. } = self.solver;
        Effort { steps: self.step_size.steps, iterations, derivatives, factorisations }
    }
}
