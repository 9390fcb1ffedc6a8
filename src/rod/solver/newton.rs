//! Newton's method on the discrete equations with an active set for taut and slack tendons.
//!
//! Taut tendons keep their length and have a tension ≥ 0; slack tendons have none and are shorter
//! than their drive allows. The set changes where a taut tendon would push or a slack one would be
//! overstretched (a primal–dual active set, equivalent to a semismooth Newton method). The
//! derivative is reused as long as it contracts well.

use nalgebra::DVector;

use super::newton_damping::NewtonDamping;
use super::newton_state::{DerivativeUse, NewtonSolver};
use super::status::SolveStatus;
use crate::rod::equations::boundary_conditions::SolveConditions;
use crate::rod::equations::system::RodEquations;

/// Iterations per taut set before a time step fails and is shortened. Converging steps take a few,
/// rarely twenty.
const MAX_ITERATIONS_WITH_ONE_SET: usize = 30;
/// Changes of the taut set during the iteration; after this many, each set is solved for first.
const QUICK_SET_CHANGES: usize = 10;
/// Iterations after which the axial weights of the balance are frozen (docs/method/robustness.md).
const FREEZE_WEIGHTS_AFTER: usize = 12;
/// Changes of the taut set after which it counts as unsettled.
const MAX_SET_CHANGES: usize = 30;
/// Largest step, in lengths of the rod; longer ones are shortened.
const MAX_STEP_LENGTHS: f64 = 0.5;
/// Contraction above which the derivative is recomputed (docs/method/rod.md).
const POOR_CONTRACTION: f64 = 0.1;

/// Assumed contraction of a reused derivative before the first measurement.
const UNPROVEN_CONTRACTION: f64 = 0.1;

/// A step at rest that is smaller than the imbalance over this stiffening factor is suspicious …
const MAX_STIFFENING: f64 = 1e4;
/// … unless both are rounding, in lengths of the rod.
const ROUNDING_LENGTHS: f64 = 1e-8;
/// Imbalance (an angle) beyond which a derivative is not reused: it belongs to a shape under
/// extreme tensions, from which every step is small (docs/method/robustness.md).
const UNRELIABLE_IMBALANCE: f64 = 1e8;

/// The correction that was subtracted from the unknowns.
struct Correction {
    step: DVector<f64>,
    /// Size before shortening, as a tip displacement, metres.
    size: f64,
    /// Whether it was shortened.
    shortened: bool,
}

impl NewtonSolver {
    /// Solves for `unknowns`, starting from their current values. `taut` is the initial guess of
    /// the set and then the result.
    pub(crate) fn solve(
        &mut self,
        system: &RodEquations,
        unknowns: &mut [f64],
        taut: &mut [bool],
        conditions: &SolveConditions,
        tolerance_m: f64,
    ) -> SolveStatus {
        let length_m = system.params.length_m();
        let mut last_size = f64::INFINITY;
        let (mut set_changes, mut set_changed_at) = (0, 0);
        self.steps.clear();
        self.damping = NewtonDamping::new();
        let needed =
            if conditions.motion.rate > 0.0 { DerivativeUse::Motion } else { DerivativeUse::Rest };
        // At rest there is neither D nor M in the matrix.
        let mut stale = self.derivative_use != needed;
        self.workspace.weights_frozen = false;
        for iteration in 0..self.max_iterations {
            // A time step can be shortened instead; a static solve has no such way out and goes on.
            if needed == DerivativeUse::Motion
                && iteration - set_changed_at == MAX_ITERATIONS_WITH_ONE_SET
            {
                break;
            }
            self.iterations += 1;
            let residual_predicted = self.residual_predicted;
            // Weights that follow the tensions can make the iteration jump to and fro without a
            // solution.
            let freeze_weights = iteration == FREEZE_WEIGHTS_AFTER;
            self.workspace.weights_frozen |= freeze_weights;
            let fresh = stale || freeze_weights;
            let current = SolveConditions { taut, ..*conditions };
            let Correction { step, size, shortened } =
                match self.correct(system, unknowns, &current, fresh) {
                    Ok(correction) => correction,
                    Err(failure) => return self.fail(failure),
                };
            // After a shortened step the shape has changed too much for the old derivative.
            stale = shortened || self.unreliable;
            // Once the sets alternate, each is solved for before the next one is tried.
            let may_change_set =
                set_changes <= QUICK_SET_CHANGES || (!shortened && size < 1e-3 * length_m);
            if may_change_set
                && self.change_set(
                    system,
                    unknowns,
                    taut,
                    conditions.constraints,
                    &step,
                    tolerance_m,
                )
            {
                set_changes += 1;
                set_changed_at = iteration + 1;
                if set_changes > MAX_SET_CHANGES {
                    return self.fail(SolveStatus::TendonSetUnsettled);
                }
                (stale, last_size) = (self.unreliable, f64::INFINITY);
                self.steps.clear();
                self.damping = NewtonDamping::new();
                continue;
            }
            let contraction =
                if last_size.is_finite() { size / last_size } else { UNPROVEN_CONTRACTION };
            // The next error is quadratic in the step with a fresh derivative, linear with a reused
            // one.
            let remaining_m =
                if fresh { size * (size / length_m).min(1.0) } else { size * contraction.min(1.0) };
            if shortened {
                self.steps.clear();
            } else if remaining_m < tolerance_m
                && !residual_predicted
                && !self.step_is_suspicious(system, size, needed)
            {
                self.residual_m = remaining_m;
                return SolveStatus::Converged;
            } else {
                self.steps.push(step);
            }
            // A poor contraction, or convergence by a predicted residual, is judged again with a
            // fresh derivative.
            stale |= contraction > POOR_CONTRACTION && last_size.is_finite();
            stale |= remaining_m < tolerance_m && !residual_predicted;
            last_size = size;
        }
        self.fail(SolveStatus::NotConverged)
    }

    /// Whether a step of `size` metres at rest is too small for the present imbalance: then the
    /// derivative belongs to another shape, under extreme tensions.
    fn step_is_suspicious(&self, system: &RodEquations, size: f64, needed: DerivativeUse) -> bool {
        let length_m = system.params.length_m();
        needed == DerivativeUse::Rest
            && self.largest_imbalance(system) * length_m
                > MAX_STIFFENING * size + ROUNDING_LENGTHS * length_m
    }

    /// The largest residual of the balance: approximately the missing angle, or the missing share
    /// of the length.
    fn largest_imbalance(&self, system: &RodEquations) -> f64 {
        self.workspace.residual[..system.grid.unknowns]
            .iter()
            .fold(0.0, |largest, r| f64::max(largest, r.abs()))
    }

    /// Evaluates the equations at `unknowns`, and their derivative when `stale`; subtracts the
    /// correction. Corrections that are too large or that alternate are shortened.
    fn correct(
        &mut self,
        system: &RodEquations,
        unknowns: &mut [f64],
        conditions: &SolveConditions,
        stale: bool,
    ) -> Result<Correction, SolveStatus> {
        // The prediction is good for one iteration only.
        if !std::mem::take(&mut self.residual_predicted) {
            system.evaluate(unknowns, conditions, &mut self.workspace);
        }
        if !self.workspace.residual.iter().all(|r| r.is_finite()) {
            return Err(SolveStatus::NotFinite);
        }
        // A contact that came or went changes the stiffness by a jump.
        if stale || self.workspace.contact_set() != self.contact_set {
            self.differentiate(system, unknowns, conditions);
        }
        self.factor(system, conditions);
        let mut step = self.step(system).ok_or(SolveStatus::NotConverged)?;
        let size = system.size_of_step_m(&step.as_slice()[..system.grid.unknowns], &self.workspace);
        if !size.is_finite() {
            return Err(SolveStatus::NotFinite);
        }
        let limit = MAX_STEP_LENGTHS * system.params.length_m();
        let share = if size > limit {
            limit / size
        } else if !(system.params.moment_laws.is_empty() && system.contact_points.is_empty()) {
            self.damping.share(system, &step, size)
        } else {
            1.0
        };
        let share = share.min(self.share_up_to_contact(system, unknowns, &step, conditions));
        let shortened = share < 1.0;
        if shortened {
            step *= share;
        }
        unknowns.iter_mut().zip(step.iter()).for_each(|(x, dx)| *x -= dx);
        Ok(Correction { step, size, shortened })
    }

    /// Computes the derivative of the residual in the workspace.
    fn differentiate(
        &mut self,
        system: &RodEquations,
        unknowns: &[f64],
        conditions: &SolveConditions,
    ) {
        self.derivatives += 1;
        self.differentiated_under = conditions.loads.tip;
        self.contact_set.clone_from(&self.workspace.contact_set());
        self.unreliable = self.largest_imbalance(system) > UNRELIABLE_IMBALANCE;
        self.derivative.update(system, unknowns, conditions, &self.workspace);
        // Factors and Broyden's steps belong to the former derivative.
        self.factors.clear();
        self.steps.clear();
        self.derivative_use =
            if conditions.motion.rate > 0.0 { DerivativeUse::Motion } else { DerivativeUse::Rest };
    }

    /// Evaluates the equations at `unknowns` and their derivative, with D and M also at rest.
    pub(crate) fn refresh(
        &mut self,
        system: &RodEquations,
        unknowns: &[f64],
        conditions: &SolveConditions,
    ) {
        self.residual_predicted = false;
        system.evaluate(unknowns, conditions, &mut self.workspace);
        self.differentiate(system, unknowns, conditions);
        if conditions.motion.rate == 0.0 {
            self.derivative.update_rates(system, conditions, &self.workspace);
        }
    }

    /// Discards the derivative of a failed solve.
    fn fail(&mut self, status: SolveStatus) -> SolveStatus {
        self.discard_derivative();
        status
    }
}
