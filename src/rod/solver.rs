//! Newton's method on the discrete equations with an active set for taut and slack tendons.
//!
//! Taut tendons hold their length with a tension ≥ 0, slack ones have none and are shorter than their drive allows:
//! the set is changed wherever a taut tendon would push or a slack one would be overstretched (a primal–dual active
//! set, which is a semismooth Newton method). The derivative is kept as long as it contracts well.

use nalgebra::{DVector, Dyn, LU};

use super::jacobian::Derivative;
use super::status::Status;
use super::system::{Conditions, Hold, System, Work};

const MOST_ITERATIONS: usize = 60;
/// A step that turns the tip by more than about this many lengths is shortened.
const LARGEST_STEP: f64 = 0.5;
/// The derivative is renewed when an iteration leaves more than this share of the step before.
const POOR_CONTRACTION: f64 = 0.1;

/// Newton iteration with everything it keeps between solves.
#[derive(Clone, Debug)]
pub(super) struct Solver {
    pub(super) work: Work,
    pub(super) derivative: Derivative,
    factors: Option<LU<f64, Dyn, Dyn>>,
    factors_rate: f64,
    factors_taut: Vec<bool>,
    /// Size of the last step, metres: what the residual is worth at the tip.
    pub(super) residual_m: f64,
    /// Iterations since construction.
    pub(super) iterations: u64,
    /// Derivatives since construction.
    pub(super) factorisations: u64,
}

impl Solver {
    pub(super) fn new(system: &System) -> Solver {
        Solver {
            work: system.work(),
            derivative: Derivative::new(system),
            factors: None,
            factors_rate: 0.0,
            factors_taut: Vec::new(),
            residual_m: 0.0,
            iterations: 0,
            factorisations: 0,
        }
    }

    /// Solves for `unknowns` from where they stand. `taut` is the guess of the set and then the answer.
    pub(super) fn solve(
        &mut self,
        system: &System,
        unknowns: &mut [f64],
        taut: &mut [bool],
        conditions: &Conditions,
        tolerance_m: f64,
    ) -> Status {
        let mut last_step = f64::INFINITY;
        let mut set_changes = 0;
        let mut fresh = false;
        if self.factors_rate != conditions.motion.rate {
            self.factors = None;
        }
        for _ in 0..MOST_ITERATIONS {
            self.iterations += 1;
            let current = Conditions { taut, ..*conditions };
            system.evaluate(unknowns, &current, &mut self.work);
            if !self.work.residual.iter().all(|r| r.is_finite()) {
                self.factors = None;
                return Status::NotFinite;
            }
            if self.factors.is_none() || self.factors_taut != *taut {
                self.refactor(system, unknowns, &current);
                fresh = true;
            }
            let Some(mut step) = self.step() else {
                self.factors = None;
                return Status::NotConverged;
            };
            let size = system.size_of_step_m(&step.as_slice()[..system.grid.unknowns]);
            if !size.is_finite() {
                self.factors = None;
                return Status::NotFinite;
            }
            let limit = LARGEST_STEP * system.params.length_m();
            let shortened = size > limit;
            if shortened {
                step *= limit / size;
            }
            for (x, dx) in unknowns.iter_mut().zip(step.iter()) {
                *x -= dx;
            }
            let changed = change_set(system, unknowns, taut, conditions.holds, &self.work, &step);
            if changed {
                set_changes += 1;
                if set_changes > 30 {
                    self.factors = None;
                    return Status::TendonSetUnsettled;
                }
                last_step = f64::INFINITY;
                continue;
            }
            // An old derivative that has not shown its contraction yet is trusted with a tenth.
            let contraction = if last_step.is_finite() { size / last_step } else { POOR_CONTRACTION };
            // With a fresh derivative the next error is of the order of the square; with an old one linear.
            let left =
                if fresh { size * (size / system.params.length_m()).min(1.0) } else { size * contraction.min(1.0) };
            if !shortened && left < tolerance_m {
                self.residual_m = left;
                return Status::Converged;
            }
            fresh = false;
            if shortened || (contraction > POOR_CONTRACTION && last_step.is_finite()) {
                self.factors = None;
            }
            last_step = size;
        }
        self.factors = None;
        Status::NotConverged
    }

    fn refactor(&mut self, system: &System, unknowns: &[f64], conditions: &Conditions) {
        self.factorisations += 1;
        self.derivative.update(system, unknowns, conditions, &self.work);
        self.factors = Some(self.derivative.matrix(system, conditions).lu());
        self.factors_rate = conditions.motion.rate;
        self.factors_taut = conditions.taut.to_vec();
    }

    fn step(&self) -> Option<DVector<f64>> {
        let mut step = DVector::from_column_slice(&self.work.residual);
        self.factors.as_ref()?.solve_mut(&mut step).then_some(step)
    }
}

/// Moves tendons between taut and slack where the step just taken says so; true if any moved.
fn change_set(
    system: &System,
    unknowns: &mut [f64],
    taut: &mut [bool],
    holds: &[Hold],
    work: &Work,
    step: &DVector<f64>,
) -> bool {
    let n = system.grid.unknowns;
    let mut changed = false;
    for (i, hold) in holds.iter().enumerate() {
        if !matches!(hold, Hold::Length(_)) {
            continue;
        }
        if taut[i] {
            if unknowns[n + i] < 0.0 {
                (taut[i], changed) = (false, true);
                unknowns[n + i] = 0.0;
            }
            continue;
        }
        // Length after the step, to first order: d length / d coefficients is the tendon's border of the derivative.
        let shift: f64 = system.length_change_m(i, work, &step.as_slice()[..n]);
        if system.overstretch_m(i, hold, 0.0, work) - shift > 1e-12 {
            (taut[i], changed) = (true, true);
        }
    }
    changed
}
