//! Newton's method on the discrete equations with an active set for taut and slack tendons.
//!
//! Taut tendons hold their length with a tension ≥ 0, slack ones have none and are shorter than their drive allows:
//! the set is changed wherever a taut tendon would push or a slack one would be overstretched (a primal–dual active
//! set, which is a semismooth Newton method). The derivative is kept as long as it contracts well.

use nalgebra::DVector;

use super::newton_damping::NewtonDamping;
use super::newton_state::{DerivativeUse, NewtonSolver};
use super::status::SolveStatus;
use crate::rod::equations::boundary_conditions::SolveConditions;
use crate::rod::equations::system::RodEquations;

/// Iterations with one taut set after which a motion is given up, for shorter steps: those that converge take a few, seldom
/// twenty.
const MOST_WITH_ONE_SET: usize = 30;
/// Changes of the taut set at any iterate; after so many, each set is solved for first.
const QUICK_SET_CHANGES: usize = 10;
/// Iterations after which the weights of the balance no longer follow the saturation of the spine.
const HOLD_WEIGHTS_AFTER: usize = 12;
const MOST_SET_CHANGES: usize = 30;
/// A step that turns the tip by more than about this many lengths is shortened.
const LARGEST_STEP: f64 = 0.5;
/// The derivative is renewed when an iteration leaves more than this share of the step before.
const POOR_CONTRACTION: f64 = 0.1;

/// What an old derivative is trusted with before it has shown its contraction.
const UNPROVEN_CONTRACTION: f64 = 0.1;

/// What tensions may stiffen a rod by; a step that is smaller yet than the imbalance says is not believed …
const MOST_STIFFENING: f64 = 1e4;
/// … unless both are rounding, in lengths of the rod.
const ROUNDING: f64 = 1e-8;
/// A derivative that was taken where the balance was open by more than this angle is not one of any rod to be kept.
const UNRELIABLE_IMBALANCE: f64 = 1e8;

/// What was taken off the unknowns.
struct Correction {
    step: DVector<f64>,
    /// Size of the whole of it as a displacement of the tip, metres.
    size: f64,
    /// Whether only a part of it was taken.
    shortened: bool,
}

impl NewtonSolver {
    /// Solves for `unknowns` from where they stand. `taut` is the guess of the set and then the answer.
    pub(crate) fn solve(
        &mut self,
        system: &RodEquations,
        unknowns: &mut [f64],
        taut: &mut [bool],
        conditions: &SolveConditions,
        tolerance_m: f64,
    ) -> SolveStatus {
        let length_m = system.params.length_m();
        let mut last_step = f64::INFINITY;
        let (mut set_changes, mut set_since) = (0, 0);
        self.steps.clear();
        self.damping = NewtonDamping::new();
        let need = if conditions.motion.rate > 0.0 { DerivativeUse::Motion } else { DerivativeUse::Rest };
        let mut stale = self.kept != need;
        self.workspace.weights_held = false;
        for iteration in 0..self.max_iterations {
            if need == DerivativeUse::Motion && iteration - set_since == MOST_WITH_ONE_SET {
                break;
            }
            self.iterations += 1;
            let residual_predicted = self.residual_predicted;
            let hold_weights = iteration == HOLD_WEIGHTS_AFTER;
            self.workspace.weights_held |= hold_weights;
            let fresh = stale || hold_weights;
            let current = SolveConditions { taut, ..*conditions };
            let Correction { step, size, shortened } = match self.correct(system, unknowns, &current, fresh) {
                Ok(correction) => correction,
                Err(failure) => return self.fail(failure),
            };
            stale = shortened || self.unreliable;
            // Once sets alternate, each is solved for before the next one is tried.
            let ripe = set_changes <= QUICK_SET_CHANGES || (!shortened && size < 1e-3 * length_m);
            if ripe && self.change_set(system, unknowns, (taut, conditions.holds), &step, tolerance_m) {
                set_changes += 1;
                set_since = iteration + 1;
                if set_changes > MOST_SET_CHANGES {
                    return self.fail(SolveStatus::TendonSetUnsettled);
                }
                (stale, last_step) = (self.unreliable, f64::INFINITY);
                self.steps.clear();
                self.damping = NewtonDamping::new();
                continue;
            }
            let contraction = if last_step.is_finite() { size / last_step } else { UNPROVEN_CONTRACTION };
            // With a fresh derivative the next error is of the order of the square; with an old one linear.
            let left = if fresh { size * (size / length_m).min(1.0) } else { size * contraction.min(1.0) };
            if shortened {
                self.steps.clear();
            } else if left < tolerance_m && !residual_predicted && !self.step_is_suspicious(system, size, need) {
                self.residual_m = left;
                return SolveStatus::Converged;
            } else {
                self.steps.push(step);
            }
            stale |= contraction > POOR_CONTRACTION && last_step.is_finite();
            stale |= left < tolerance_m && !residual_predicted;
            last_step = size;
        }
        self.fail(SolveStatus::NotConverged)
    }

    /// Whether a step of `size` metres at rest is suspiciously small for the balance that it is to restore: then the
    /// derivative is that of another shape, under tensions beyond measure.
    fn step_is_suspicious(&self, system: &RodEquations, size: f64, need: DerivativeUse) -> bool {
        let length_m = system.params.length_m();
        need == DerivativeUse::Rest
            && self.largest_imbalance(system) * length_m > MOST_STIFFENING * size + ROUNDING * length_m
    }

    /// The largest residual of the balance: about the angle that the rod lacks, or the share of its length.
    fn largest_imbalance(&self, system: &RodEquations) -> f64 {
        self.workspace.residual[..system.grid.unknowns].iter().fold(0.0, |largest, r| f64::max(largest, r.abs()))
    }

    /// Evaluates the equations at `unknowns`, their derivative as well when it is `stale`, and takes the correction off
    /// the unknowns. A correction that is too large is shortened, and one that goes back and forth.
    fn correct(
        &mut self,
        system: &RodEquations,
        unknowns: &mut [f64],
        conditions: &SolveConditions,
        stale: bool,
    ) -> Result<Correction, SolveStatus> {
        if !std::mem::take(&mut self.residual_predicted) {
            system.evaluate(unknowns, conditions, &mut self.workspace);
        }
        if !self.workspace.residual.iter().all(|r| r.is_finite()) {
            return Err(SolveStatus::NotFinite);
        }
        if stale {
            self.derivatives += 1;
            self.unreliable = self.largest_imbalance(system) > UNRELIABLE_IMBALANCE;
            self.derivative.update(system, unknowns, conditions, &self.workspace);
            self.factors.clear();
            self.steps.clear();
            self.kept = if conditions.motion.rate > 0.0 { DerivativeUse::Motion } else { DerivativeUse::Rest };
        }
        self.factor(system, conditions);
        let mut step = self.step(system).ok_or(SolveStatus::NotConverged)?;
        let size = system.size_of_step_m(&step.as_slice()[..system.grid.unknowns], &self.workspace);
        if !size.is_finite() {
            return Err(SolveStatus::NotFinite);
        }
        let limit = LARGEST_STEP * system.params.length_m();
        let share = if size > limit {
            limit / size
        } else if !system.params.moment_laws.is_empty() {
            self.damping.share(system, &step, size)
        } else {
            1.0
        };
        let shortened = share < 1.0;
        if shortened {
            step *= share;
        }
        unknowns.iter_mut().zip(step.iter()).for_each(|(x, dx)| *x -= dx);
        Ok(Correction { step, size, shortened })
    }

    /// A failed solve leaves no derivative worth keeping.
    fn fail(&mut self, status: SolveStatus) -> SolveStatus {
        self.kept = DerivativeUse::Nothing;
        status
    }
}
