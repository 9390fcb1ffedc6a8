//! Newton's method on the discrete equations with an active set for taut and slack tendons.
//!
//! Taut tendons hold their length with a tension ≥ 0, slack ones have none and are shorter than their drive allows:
//! the set is changed wherever a taut tendon would push or a slack one would be overstretched (a primal–dual active
//! set, which is a semismooth Newton method). The derivative is kept as long as it contracts well.

use nalgebra::{DVector, Dyn, LU};

use super::conditions::{Conditions, Hold};
use super::jacobian::Derivative;
use super::status::Status;
use super::system::{System, Work};

const MOST_ITERATIONS: usize = 150;
/// Changes of the taut set at any iterate; after so many, each set is solved for first.
const QUICK_SET_CHANGES: usize = 10;
const MOST_SET_CHANGES: usize = 30;
/// A tendon may be overstretched by this share of the solve's tolerance before it counts as taut …
const SET_TOLERANCE: f64 = 0.1;
/// … and push by as much as such a stretch is worth: about the compliance of the softest spine, m/N.
const PUSH_M_PER_N: f64 = 1e-3;
/// A step that turns the tip by more than about this many lengths is shortened.
const LARGEST_STEP: f64 = 0.5;
/// The derivative is renewed when an iteration leaves more than this share of the step before.
const POOR_CONTRACTION: f64 = 0.1;

/// Factors kept for one derivative: a few step lengths and taut sets come back again and again.
const MOST_FACTORS: usize = 8;

/// A correction that is to undo more than this share of the one before is taken as it is.
const MOST_ACCELERATION: f64 = 0.5;

/// What an old derivative is trusted with before it has shown its contraction.
const UNPROVEN_CONTRACTION: f64 = 0.1;

/// Newton iteration with everything it keeps between solves.
#[derive(Clone, Debug)]
pub(super) struct Solver {
    pub(super) work: Work,
    pub(super) derivative: Derivative,
    /// Factors of the derivative for the rates and taut sets it was last used with; the newest last.
    factors: Vec<Factors>,
    /// What the derivative is good for.
    kept: Kept,
    /// Steps of the present solve since the derivative or the taut set changed.
    steps: Vec<DVector<f64>>,
    /// Size of the last step, metres: what the residual is worth at the tip.
    pub(super) residual_m: f64,
    /// Iterations since construction.
    pub(super) iterations: u64,
    /// Derivatives since construction.
    pub(super) derivatives: u64,
    /// Factorisations since construction.
    pub(super) factorisations: u64,
}

/// What a derivative is good for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kept {
    Nothing,
    Rest,
    Motion,
}

/// The factorised derivative for one rate and taut set.
#[derive(Clone, Debug)]
struct Factors {
    rate: f64,
    taut: Vec<bool>,
    lu: LU<f64, Dyn, Dyn>,
}

impl Solver {
    pub(super) fn new(system: &System) -> Solver {
        Solver {
            work: system.work(),
            derivative: Derivative::new(system),
            factors: Vec::new(),
            kept: Kept::Nothing,
            steps: Vec::new(),
            residual_m: 0.0,
            iterations: 0,
            derivatives: 0,
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
        self.steps.clear();
        let mut fresh = false;
        let need = if conditions.motion.rate > 0.0 { Kept::Motion } else { Kept::Rest };
        let mut stale = self.kept != need;
        for _ in 0..MOST_ITERATIONS {
            self.iterations += 1;
            let current = Conditions { taut, ..*conditions };
            system.evaluate(unknowns, &current, &mut self.work);
            if !self.work.residual.iter().all(|r| r.is_finite()) {
                return self.give_up(Status::NotFinite);
            }
            if stale {
                self.derivatives += 1;
                self.derivative.update(system, unknowns, &current, &self.work);
                self.factors.clear();
                self.steps.clear();
                self.kept = need;
                (stale, fresh) = (false, true);
            }
            self.factor(system, &current);
            let Some(mut step) = self.step(system) else { return self.give_up(Status::NotConverged) };
            let size = system.size_of_step_m(&step.as_slice()[..system.grid.unknowns]);
            if !size.is_finite() {
                return self.give_up(Status::NotFinite);
            }
            let limit = LARGEST_STEP * system.params.length_m();
            let shortened = size > limit;
            if shortened {
                step *= limit / size;
                self.steps.clear();
            }
            for (x, dx) in unknowns.iter_mut().zip(step.iter()) {
                *x -= dx;
            }
            // Once sets alternate, each is solved for before the next one is tried.
            let patient = set_changes > QUICK_SET_CHANGES;
            let ripe = !patient || (!shortened && size < 1e-3 * system.params.length_m());
            if ripe && self.change_set(system, unknowns, (taut, conditions.holds), &step, tolerance_m) {
                set_changes += 1;
                if set_changes > MOST_SET_CHANGES {
                    return self.give_up(Status::TendonSetUnsettled);
                }
                fresh = false;
                last_step = f64::INFINITY;
                self.steps.clear();
                continue;
            }
            if !shortened {
                self.steps.push(step);
            }
            let contraction = if last_step.is_finite() { size / last_step } else { UNPROVEN_CONTRACTION };
            // With a fresh derivative the next error is of the order of the square; with an old one linear.
            let left =
                if fresh { size * (size / system.params.length_m()).min(1.0) } else { size * contraction.min(1.0) };
            if !shortened && left < tolerance_m {
                self.residual_m = left;
                return Status::Converged;
            }
            fresh = false;
            if shortened || (contraction > POOR_CONTRACTION && last_step.is_finite()) {
                stale = true;
            }
            last_step = size;
        }
        self.give_up(Status::NotConverged)
    }

    /// A failed solve leaves no derivative worth keeping.
    fn give_up(&mut self, status: Status) -> Status {
        self.kept = Kept::Nothing;
        status
    }

    /// Brings the factors of the derivative for the rate and the taut set of `conditions` to the end of the list.
    fn factor(&mut self, system: &System, conditions: &Conditions) {
        let rate = conditions.motion.rate;
        let known = self.factors.iter().position(|f| f.rate == rate && f.taut == conditions.taut);
        let newest = match known {
            Some(index) => self.factors.remove(index),
            None => {
                self.factorisations += 1;
                if self.factors.len() == MOST_FACTORS {
                    self.factors.remove(0);
                }
                let lu = self.derivative.matrix(system, conditions).lu();
                Factors { rate, taut: conditions.taut.to_vec(), lu }
            }
        };
        self.factors.push(newest);
    }

    /// The next correction, with Broyden's update of the factors by the corrections so far (Kelley, Solving Nonlinear
    /// Equations with Newton's Method, 2003, section 4.1), in the norm that counts a change by what it moves the tip.
    fn step(&self, system: &System) -> Option<DVector<f64>> {
        let mut step = DVector::from_column_slice(&self.work.residual);
        if !self.factors.last()?.lu.solve_mut(&mut step) {
            return None;
        }
        let product = |a: &DVector<f64>, b: &DVector<f64>| -> f64 {
            a.iter().zip(b.iter()).zip(&system.scales).map(|((x, y), scale)| x * y * scale * scale).sum()
        };
        let mut steps = self.steps.iter().peekable();
        while let Some(earlier) = steps.next() {
            let share = product(earlier, &step) / product(earlier, earlier);
            match steps.peek() {
                Some(next) => step.axpy(share, next, 1.0),
                None if share.abs() < MOST_ACCELERATION => step /= 1.0 - share,
                None => (),
            }
        }
        Some(step)
    }

    /// Moves the tendon that offends most between taut and slack, as the step just taken says; true if one moved.
    /// One at a time: more taut tendons than the shape has freedom for would contradict each other.
    fn change_set(
        &self,
        system: &System,
        unknowns: &mut [f64],
        (taut, holds): (&mut [bool], &[Hold]),
        step: &DVector<f64>,
        tolerance_m: f64,
    ) -> bool {
        let n = system.grid.unknowns;
        let (mut worst, mut offence) = (None, SET_TOLERANCE * tolerance_m);
        for (i, hold) in holds.iter().enumerate() {
            let own = match hold {
                Hold::Tension(_) => continue,
                Hold::Length(_) if taut[i] => -unknowns[n + i] * PUSH_M_PER_N,
                Hold::Length(_) => {
                    // Length after the step, to first order.
                    let shift = self.derivative.length_change_m(system, i, &step.as_slice()[..n]);
                    system.overstretch_m(i, hold, 0.0, &self.work) - shift
                }
            };
            if own > offence {
                (worst, offence) = (Some(i), own);
            }
        }
        if let Some(i) = worst {
            taut[i] = !taut[i];
            unknowns[n + i] = 0.0;
        }
        worst.is_some()
    }
}
