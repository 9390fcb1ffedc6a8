//! Newton's method on the discrete equations with an active set for taut and slack tendons.
//!
//! Taut tendons hold their length with a tension ≥ 0, slack ones have none and are shorter than their drive allows:
//! the set is changed wherever a taut tendon would push or a slack one would be overstretched (a primal–dual active
//! set, which is a semismooth Newton method). The derivative is kept as long as it contracts well.

pub(crate) mod status;
pub(crate) mod newton_damping;

use nalgebra::{DVector, Dyn, LU};

use super::equations::boundary_conditions::{Conditions, Hold};
use super::equations::jacobian::Derivative;
use super::equations::system::{System, Work};
use self::status::Status;
use newton_damping::Damping;

const MOST_ITERATIONS: usize = 150;
/// Iterations with one taut set after which a motion is given up, for shorter steps: those that converge take a few, seldom
/// twenty.
const MOST_WITH_ONE_SET: usize = 30;
/// Changes of the taut set at any iterate; after so many, each set is solved for first.
const QUICK_SET_CHANGES: usize = 10;
/// Iterations after which the weights of the balance no longer follow the saturation of the spine.
const HOLD_WEIGHTS_AFTER: usize = 12;
const MOST_SET_CHANGES: usize = 30;
/// A tendon may be overstretched by this share of the solve's tolerance before it counts as taut, and its push may move
/// the tip by as much before it counts as slack.
const SET_TOLERANCE: f64 = 0.1;
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

/// What tensions may stiffen a rod by; a step that is smaller yet than the imbalance says is not believed …
const MOST_STIFFENING: f64 = 1e4;
/// … unless both are rounding, in lengths of the rod.
const ROUNDING: f64 = 1e-8;
/// A derivative that was taken where the balance was open by more than this angle is not one of any rod to be kept.
const WILD: f64 = 1e8;

/// Newton iteration with everything it keeps between solves.
#[derive(Clone, Debug)]
pub(super) struct Solver {
    pub(super) work: Work,
    pub(super) derivative: Derivative,
    /// Factors of the derivative for the rates and taut sets it was last used with; the newest last.
    factors: Vec<Factors>,
    /// What the derivative is good for.
    kept: Kept,
    /// Whether the derivative is that of a shape beyond measure.
    wild: bool,
    /// Whether the residual in `work` is that of the next solve's first iteration.
    foretold: bool,
    /// Steps of the present solve since the derivative or the taut set changed.
    steps: Vec<DVector<f64>>,
    /// What of a correction is taken of a rod that remembers.
    damping: Damping,
    /// Size of the last step, metres: what the residual is worth at the tip.
    pub(super) residual_m: f64,
    /// Iterations after which a solve is given up.
    pub(super) patience: usize,
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

/// What was taken off the unknowns.
struct Correction {
    step: DVector<f64>,
    /// Size of the whole of it as a displacement of the tip, metres.
    size: f64,
    /// Whether only a part of it was taken.
    shortened: bool,
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
            wild: false,
            foretold: false,
            steps: Vec::new(),
            damping: Damping::new(),
            residual_m: 0.0,
            patience: MOST_ITERATIONS,
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
        let length_m = system.params.length_m();
        let mut last_step = f64::INFINITY;
        let (mut set_changes, mut set_since) = (0, 0);
        self.steps.clear();
        self.damping = Damping::new();
        let need = if conditions.motion.rate > 0.0 { Kept::Motion } else { Kept::Rest };
        let mut stale = self.kept != need;
        self.work.weights_held = false;
        for iteration in 0..self.patience {
            if need == Kept::Motion && iteration - set_since == MOST_WITH_ONE_SET {
                break;
            }
            self.iterations += 1;
            let foretold = self.foretold;
            let hold_weights = iteration == HOLD_WEIGHTS_AFTER;
            self.work.weights_held |= hold_weights;
            let fresh = stale || hold_weights;
            let current = Conditions { taut, ..*conditions };
            let Correction { step, size, shortened } = match self.correct(system, unknowns, &current, fresh) {
                Ok(correction) => correction,
                Err(failure) => return self.give_up(failure),
            };
            stale = shortened || self.wild;
            // Once sets alternate, each is solved for before the next one is tried.
            let ripe = set_changes <= QUICK_SET_CHANGES || (!shortened && size < 1e-3 * length_m);
            if ripe && self.change_set(system, unknowns, (taut, conditions.holds), &step, tolerance_m) {
                set_changes += 1;
                set_since = iteration + 1;
                if set_changes > MOST_SET_CHANGES {
                    return self.give_up(Status::TendonSetUnsettled);
                }
                (stale, last_step) = (self.wild, f64::INFINITY);
                self.steps.clear();
                self.damping = Damping::new();
                continue;
            }
            let contraction = if last_step.is_finite() { size / last_step } else { UNPROVEN_CONTRACTION };
            // With a fresh derivative the next error is of the order of the square; with an old one linear.
            let left = if fresh { size * (size / length_m).min(1.0) } else { size * contraction.min(1.0) };
            if shortened {
                self.steps.clear();
            } else if left < tolerance_m && !foretold && !self.doubtful(system, size, need) {
                self.residual_m = left;
                return Status::Converged;
            } else {
                self.steps.push(step);
            }
            stale |= contraction > POOR_CONTRACTION && last_step.is_finite();
            stale |= left < tolerance_m && !foretold;
            last_step = size;
        }
        self.give_up(Status::NotConverged)
    }

    /// Whether a step of `size` metres at rest is suspiciously small for the balance that it is to restore: then the
    /// derivative is that of another shape, under tensions beyond measure.
    fn doubtful(&self, system: &System, size: f64, need: Kept) -> bool {
        let length_m = system.params.length_m();
        need == Kept::Rest && self.largest_imbalance(system) * length_m > MOST_STIFFENING * size + ROUNDING * length_m
    }

    /// The largest residual of the balance: about the angle that the rod lacks, or the share of its length.
    fn largest_imbalance(&self, system: &System) -> f64 {
        self.work.residual[..system.grid.unknowns].iter().fold(0.0, |largest, r| f64::max(largest, r.abs()))
    }

    /// Evaluates the equations at `unknowns`, their derivative as well when it is `stale`, and takes the correction off
    /// the unknowns. A correction that is too large is shortened, and one that goes back and forth.
    fn correct(
        &mut self,
        system: &System,
        unknowns: &mut [f64],
        conditions: &Conditions,
        stale: bool,
    ) -> Result<Correction, Status> {
        if !std::mem::take(&mut self.foretold) {
            system.evaluate(unknowns, conditions, &mut self.work);
        }
        if !self.work.residual.iter().all(|r| r.is_finite()) {
            return Err(Status::NotFinite);
        }
        if stale {
            self.derivatives += 1;
            self.wild = self.largest_imbalance(system) > WILD;
            self.derivative.update(system, unknowns, conditions, &self.work);
            self.factors.clear();
            self.steps.clear();
            self.kept = if conditions.motion.rate > 0.0 { Kept::Motion } else { Kept::Rest };
        }
        self.factor(system, conditions);
        let mut step = self.step(system).ok_or(Status::NotConverged)?;
        let size = system.size_of_step_m(&step.as_slice()[..system.grid.unknowns], &self.work);
        if !size.is_finite() {
            return Err(Status::NotFinite);
        }
        let limit = LARGEST_STEP * system.params.length_m();
        let share = if size > limit {
            limit / size
        } else if !system.params.memory.is_empty() {
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

    /// Tells the next solve its first residual, which is nothing but what tendons `was` held to and `will` be, if the
    /// `unknowns` and the `taut` set are a solution that the derivative at hand has led to.
    pub(super) fn foretell(
        &mut self,
        system: &System,
        (unknowns, taut): (&[f64], &[bool]),
        (was, will): (&[Hold], &[Hold]),
    ) {
        let led = |factors: &Factors| factors.rate == 0.0 && factors.taut == taut;
        if self.kept != Kept::Rest || self.wild || !self.factors.last().is_some_and(led) {
            return;
        }
        let n = system.grid.unknowns;
        let alike = was.iter().zip(will).all(|pair| match pair {
            (Hold::Length(_), Hold::Length(_)) => true,
            (before, after) => before == after,
        });
        if !alike {
            return;
        }
        self.work.residual.fill(0.0);
        for (i, (before, after)) in was.iter().zip(will).enumerate().filter(|&(i, _)| taut[i]) {
            let overstretch_m = |hold: &Hold| system.overstretch_m(i, hold, unknowns[n + i], &self.work);
            self.work.residual[n + i] = overstretch_m(after) - overstretch_m(before);
        }
        self.foretold = true;
    }

    /// Divides by the derivative that the last solve ended with; false when it is singular.
    pub(super) fn divide(&self, residual: &mut DVector<f64>) -> bool {
        self.factors.last().is_some_and(|factors| factors.lu.solve_mut(residual))
    }

    /// Makes the next solve begin with a new derivative.
    pub(super) fn forget(&mut self) {
        self.kept = Kept::Nothing;
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
        let mut steps = self.steps.iter().peekable();
        while let Some(earlier) = steps.next() {
            let share = system.product_m2(earlier, &step) / system.product_m2(earlier, earlier);
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
                Hold::Length(_) if taut[i] => -unknowns[n + i] * system.reach_m_per_n[i],
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
