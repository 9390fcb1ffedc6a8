//! The boundary value problem: base wrench and tensions for which the tip is in balance and the
//! tendons have their lengths.

use nalgebra::{DMatrix, DVector, Dyn, LU};
use spinebench::rod::Drive;

use super::{Solver, Till};

/// Finite-difference increments: this share of an unknown, or at least so much.
const INCREMENT: f64 = 1e-7;
const LEAST_INCREMENT: f64 = 1e-9;
const MOST_ITERATIONS: usize = 1500;
const DAMPING: f64 = 1e-2;
const ADAPTATION: f64 = 0.5;
/// Newton's derivative is renewed when an iteration leaves more than this share of the residual.
const POOR_CONTRACTION: f64 = 0.1;

/// What is kept between solves.
#[derive(Default)]
pub(super) struct Memory {
    factors: Option<LU<f64, Dyn, Dyn>>,
    /// The solution before the last one.
    before: Option<DVector<f64>>,
}

impl Memory {
    pub(super) fn forget(&mut self) {
        *self = Memory::default();
    }
}

impl<const T: usize> Till<T> {
    pub(super) fn solve(&mut self, drives: &[Drive]) -> Result<(), String> {
        let guess = self.guess.clone();
        let solved = match self.settings.solver {
            Solver::LevenbergMarquardt => self.levenberg_marquardt(guess, drives)?,
            Solver::Newton => {
                // From the last solution and straight on from the last two, in the wanted order;
                // then with care.
                let ahead = self.memory.before.as_ref().map(|before| &guess * 2.0 - before);
                let mut starts: Vec<DVector<f64>> =
                    [Some(guess.clone()), ahead].into_iter().flatten().collect();
                if self.settings.extrapolate {
                    starts.reverse();
                }
                let mut solved = Err(String::new());
                for start in starts {
                    if solved.is_err() {
                        solved = self.newton(start, drives);
                    }
                    if solved.is_err() {
                        self.memory.factors = None;
                    }
                }
                if solved.is_err() {
                    solved = self.levenberg_marquardt(guess, drives);
                }
                solved?
            }
        };
        self.memory.before = Some(std::mem::replace(&mut self.guess, solved));
        Ok(())
    }

    fn derivative(
        &mut self,
        guess: &DVector<f64>,
        error: &DVector<f64>,
        drives: &[Drive],
    ) -> DMatrix<f64> {
        let mut jacobian = DMatrix::zeros(error.len(), guess.len());
        for c in 0..guess.len() {
            let increment = (INCREMENT * guess[c].abs()).max(LEAST_INCREMENT);
            let mut shifted = guess.clone();
            shifted[c] += increment;
            let column = (self.shoot(&shifted, drives, false) - error) / increment;
            jacobian.set_column(c, &column);
        }
        jacobian
    }

    fn levenberg_marquardt(
        &mut self,
        mut guess: DVector<f64>,
        drives: &[Drive],
    ) -> Result<DVector<f64>, String> {
        let mut error = self.shoot(&guess, drives, true);
        let mut left = error.norm_squared();
        let mut damping = DAMPING;
        let mut iterations = 0;
        while left.is_nan() || left > self.settings.tolerance {
            let jacobian = self.derivative(&guess, &error, drives);
            if !jacobian.iter().all(|x| x.is_finite()) {
                return Err("not finite".into());
            }
            let square = jacobian.tr_mul(&jacobian);
            let gradient = jacobian.tr_mul(&error);
            damping *= ADAPTATION;
            loop {
                iterations += 1;
                if iterations > MOST_ITERATIONS {
                    return Err("no convergence".into());
                }
                let damped = &square + DMatrix::identity(guess.len(), guess.len()) * damping;
                let trial = damped.cholesky().map(|factors| &guess - factors.solve(&gradient));
                if let Some(trial) = trial {
                    let after = self.shoot(&trial, drives, true);
                    if after.norm_squared() < left {
                        (guess, error, left) = (trial, after.clone(), after.norm_squared());
                        break;
                    }
                }
                damping /= ADAPTATION;
            }
        }
        Ok(guess)
    }

    fn newton(
        &mut self,
        mut guess: DVector<f64>,
        drives: &[Drive],
    ) -> Result<DVector<f64>, String> {
        let mut left = f64::INFINITY;
        for _ in 0..40 {
            let error = self.shoot(&guess, drives, true);
            let now = error.norm_squared();
            if !now.is_finite() {
                return Err("not finite".into());
            }
            if now <= self.settings.tolerance {
                return Ok(guess);
            }
            if self.memory.factors.is_none() || now > POOR_CONTRACTION * POOR_CONTRACTION * left {
                self.memory.factors = Some(self.derivative(&guess, &error, drives).lu());
            }
            let step = self.memory.factors.as_ref().and_then(|factors| factors.solve(&error));
            guess -= step.ok_or("singular")?;
            left = now;
        }
        Err("no convergence".into())
    }
}
