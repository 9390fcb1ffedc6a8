//! LU factors of the derivative, kept between iterations and solves.

use nalgebra::DVector;

use super::newton_state::{LuFactors, NewtonSolver};
use crate::rod::equations::boundary_conditions::SolveConditions;
use crate::rod::equations::system::RodEquations;

/// Factorisations kept per derivative: a few step lengths and taut sets recur.
const MAX_FACTORS: usize = 8;
/// Broyden updates that would cancel more than this share of the previous step are not applied.
const MAX_ACCELERATION: f64 = 0.5;

impl NewtonSolver {
    /// Moves the factors for the rate and the taut set of `conditions` to the end of the list;
    /// factorises if needed.
    pub(super) fn factor(&mut self, system: &RodEquations, conditions: &SolveConditions) {
        let rate = conditions.motion.rate;
        let cached = self.factors.iter().position(|f| f.rate == rate && f.taut == conditions.taut);
        let newest = match cached {
            Some(index) => self.factors.remove(index),
            None => {
                self.factorisations += 1;
                if self.factors.len() == MAX_FACTORS {
                    // The least recently used one goes: hits move to the end.
                    self.factors.remove(0);
                }
                let lu = self.derivative.matrix(system, conditions).lu();
                LuFactors { rate, taut: conditions.taut.to_vec(), lu }
            }
        };
        self.factors.push(newest);
    }

    /// The next Newton step, with Broyden's update from the steps so far (Kelley, Solving Nonlinear
    /// Equations with Newton's Method, 2003, section 4.1), in the norm of tip displacements.
    pub(super) fn step(&self, system: &RodEquations) -> Option<DVector<f64>> {
        // Chord step with the factors at hand, then the rank-one updates in order.
        let mut step = DVector::from_column_slice(&self.workspace.residual);
        if !self.factors.last()?.lu.solve_mut(&mut step) {
            return None;
        }
        let mut steps = self.steps.iter().peekable();
        while let Some(earlier) = steps.next() {
            let share = system.product_m2(earlier, &step) / system.product_m2(earlier, earlier);
            match steps.peek() {
                Some(next) => step.axpy(share, next, 1.0),
                // Sherman–Morrison for the last update; near 1 its denominator vanishes.
                None if share.abs() < MAX_ACCELERATION => step /= 1.0 - share,
                None => (),
            }
        }
        Some(step)
    }

    /// Solves with the factors that the last solve ended with; false when they are singular.
    pub(crate) fn solve_with_last_factors(&self, residual: &mut DVector<f64>) -> bool {
        self.factors.last().is_some_and(|factors| factors.lu.solve_mut(residual))
    }
}
