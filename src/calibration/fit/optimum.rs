//! The fit: Levenberg–Marquardt with bounds, priors and weights (Nocedal & Wright, Numerical
//! Optimization, sections 10.3 and 16.7: coordinates at a bound that the gradient pushes against
//! are held).

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::calibration::compare::comparison::{Comparison, Positions};
use crate::calibration::compare::robust::{ErrorLaw, weights};
use crate::calibration::error::CalibrationError;
use crate::calibration::numbers::number::{FitNumber, with_coordinates};
use crate::effects::Model;
use crate::math::optimise::least_squares::unseen_left_out;

/// A number that moves no point by more than [`POINT_ACCURACY_M`] when its coordinate changes by
/// this is not observable.
const OBSERVABLE_CHANGE: f64 = 1e-3;
/// Accuracy of a simulated point, metres: the rod's tolerance.
const POINT_ACCURACY_M: f64 = 1e-8;
/// Largest damping: then a step is a hundred-thousandth of the undamped one.
const MAX_DAMPING: f64 = 1e5;
/// Smallest damping: the step is that of Gauss and Newton.
const MIN_DAMPING: f64 = 1e-6;
/// Improvement of the sum of squares below which a fit has converged, in variances of one
/// coordinate: a tenth of a standard error, or, for a start of another fit, one.
pub(crate) const CONVERGED: f64 = 1e-2;
pub(crate) const ROUGHLY_CONVERGED: f64 = 1.0;
/// A step that gains this share of what the linear model expects of it is long enough, and leaves a
/// good derivative behind …
const GOOD_GAIN: f64 = 0.5;
/// … for so many steps, as long as steps promise this share of the undamped one.
const MAX_SECANTS: usize = 6;
const SECANT_GAIN: f64 = 0.1;
/// Largest share of rows that the model may leave without a solution.
const MAX_FAILED_SHARE: f64 = 0.2;
/// Largest share of the solved rows that a step may lose.
const MAX_LOST_SHARE: f64 = 0.02;

/// A fit at its optimum, or where it stopped.
#[derive(Clone, Debug)]
pub(crate) struct Optimum {
    /// Coordinates of the numbers.
    pub(crate) x: Vec<f64>,
    /// What the model says of each sighting.
    pub(crate) positions: Positions,
    /// Derivative of the positions, three rows a sighting; zero for numbers without influence and
    /// sightings without solution.
    pub(crate) slopes: DMatrix<f64>,
    /// Simulated minus measured, three a sighting, metres; zero where there is no solution.
    pub(crate) residual_m: DVector<f64>,
    /// Weight of each sighting.
    pub(crate) weights: Vec<f64>,
    /// Variance of one coordinate of a sighting, m².
    pub(crate) variance_m2: f64,
    /// Whether no more improvement was possible within the iterations.
    pub(crate) converged: bool,
}

/// A step that lowers the weighted sum of squares.
struct AcceptedStep {
    /// Coordinates that it leads to.
    x: Vec<f64>,
    /// What the model says there.
    positions: Positions,
    /// By how much it lowers the sum, m², and by how much the linear model would have it.
    gain: f64,
    expected: f64,
}

impl AcceptedStep {
    /// Whether the linear model holds over the step.
    fn is_good(&self) -> bool {
        self.gain > GOOD_GAIN * self.expected
    }
}

/// The first good step at a growing damping, or the one after which they gain less.
/// `damping` is left where the next step should begin (Fletcher 1971).
fn longest(damping: &mut f64, step: impl Fn(f64) -> Option<AcceptedStep>) -> Option<AcceptedStep> {
    let mut best: Option<AcceptedStep> = None;
    while *damping < MAX_DAMPING {
        match step(*damping) {
            // Where the model bends more than expected a shorter step may gain more.
            Some(step) if best.as_ref().is_none_or(|best| step.gain > best.gain) => {
                let is_good = step.is_good();
                best = Some(step);
                if is_good {
                    // The region in which the linear model holds grows again.
                    *damping *= 0.2;
                    return best;
                }
            }
            _ if best.is_some() => return best,
            _ => {}
        }
        *damping *= 10.0;
    }
    // A later step starts afresh: the largest damping would leave it nowhere to go.
    *damping = 1e-3;
    best
}

/// What is fitted to what.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CalibrationProblem<'a> {
    pub(crate) model: &'a Model,
    pub(crate) numbers: &'a [FitNumber],
    pub(crate) comparison: &'a Comparison<'a>,
    pub(crate) likelihood: ErrorLaw,
}

impl CalibrationProblem<'_> {
    /// The model at some coordinates.
    pub(crate) fn at(&self, x: &[f64]) -> Option<Model> {
        with_coordinates(self.model, self.numbers, x)
    }

    /// Fits from `start` in at most `iterations` steps, until one gains less than `converged`
    /// variances of a coordinate.
    ///
    /// # Errors
    /// [`CalibrationError::NotSimulated`] when the model has no solution for many of the rows at
    /// the start.
    pub(crate) fn fit(
        &self,
        start: &[f64],
        iterations: usize,
        converged: f64,
    ) -> Result<Optimum, CalibrationError> {
        let mut here = self.evaluated(start).ok_or_else(|| self.not_simulated(&[]))?;
        let failed = here.positions.iter().filter(|at| at.is_none()).count();
        if failed as f64 > MAX_FAILED_SHARE * here.positions.len() as f64 {
            return Err(self.not_simulated(&here.positions));
        }
        let mut damping = 1e-3;
        let mut secants = 0;
        for _ in 0..iterations {
            // Ask the linear model first: it costs no simulation.
            let expected = self.expected_gain(&here);
            let enough = converged * here.variance_m2;
            // With a secant, a new derivative is better than a much shorter step.
            let least = if secants > 0 { enough.max(SECANT_GAIN * expected) } else { enough };
            let step =
                (expected >= enough).then(|| self.improved(&here, &mut damping, least)).flatten();
            let is_small = step.as_ref().is_none_or(|step| step.gain < enough);
            if secants == 0 && step.is_none() {
                here.converged = true;
                break;
            }
            let x = step.as_ref().map_or_else(|| here.x.clone(), |step| step.x.clone());
            // A derivative costs as much as many steps; a secant of the last step renews it for
            // nothing while the steps gain what the linear model expects.
            match step.as_ref().filter(|step| step.is_good()) {
                Some(step) if !is_small && secants < MAX_SECANTS => {
                    secants += 1;
                    here = self.with_secant(&here, step);
                }
                _ => {
                    // Weights and variance are taken anew, which is the reweighting of robust fits.
                    let Some(next) = self.evaluated(&x) else { break };
                    here = next;
                    if secants == 0 && is_small {
                        here.converged = true;
                        break;
                    }
                    secants = 0;
                }
            }
        }
        if secants > 0
            && let Some(exact) = self.evaluated(&here.x)
        {
            here = exact;
        }
        Ok(here)
    }

    /// Positions, derivative and weights at `x`; `None` when the model cannot be evaluated.
    pub(crate) fn evaluated(&self, x: &[f64]) -> Option<Optimum> {
        let model = self.at(x)?;
        let (mut positions, slopes) = self.comparison.with_slopes(&model, self.numbers, x)?;
        if positions.iter().any(Option::is_none) {
            // A row whose derivative is not found counts all the same: steps must not win by it.
            let alone = self.comparison.positions(&model);
            positions.iter_mut().zip(alone).for_each(|(at, alone)| *at = at.or(alone));
        }
        // Slopes below the solver's accuracy are rounding and would look like information.
        let slopes = unseen_left_out(slopes, OBSERVABLE_CHANGE, POINT_ACCURACY_M);
        Some(self.weighted(x.to_vec(), positions, slopes))
    }

    fn weighted(&self, x: Vec<f64>, positions: Positions, slopes: DMatrix<f64>) -> Optimum {
        let residual_m = self.residual_m(&positions);
        let (weights, variance_m2) =
            weights(self.likelihood, &residual_m, &positions, self.numbers.len());
        Optimum { x, positions, slopes, residual_m, weights, variance_m2, converged: false }
    }

    /// Where a step has led, with the derivative that agrees with the step and is else the former
    /// one (Broyden 1965), in Marquardt's scaling.
    fn with_secant(&self, here: &Optimum, step: &AcceptedStep) -> Optimum {
        let (normal, _) = self.normal(here);
        let change = DVector::from_fn(here.x.len(), |k, _| step.x[k] - here.x[k]);
        let scaled = DVector::from_fn(here.x.len(), |k, _| normal[(k, k)] * change[k]);
        let mut missed = self.residual_m(&step.positions) - &here.residual_m;
        missed.gemv(-1.0, &here.slopes, &change, 1.0);
        for (index, (before, after)) in here.positions.iter().zip(&step.positions).enumerate() {
            if before.is_none() || after.is_none() {
                missed.rows_mut(3 * index, 3).fill(0.0);
            }
        }
        let mut slopes = here.slopes.clone();
        slopes.ger(1.0 / change.dot(&scaled), &missed, &scaled, 1.0);
        self.weighted(step.x.clone(), step.positions.clone(), slopes)
    }

    /// Simulated minus measured; zero where there is no solution.
    pub(crate) fn residual_m(&self, positions: &Positions) -> DVector<f64> {
        let each =
            positions.iter().zip(&self.comparison.sightings).flat_map(|(at, sighting)| match at {
                Some(at) => [0, 1, 2].map(|axis| at[axis] - sighting.at_m[axis]),
                None => [0.0; 3],
            });
        DVector::from_iterator(3 * positions.len(), each)
    }

    fn not_simulated(&self, positions: &[Option<[f64; 3]>]) -> CalibrationError {
        let failed = |index: &usize| positions.get(*index).is_none_or(Option::is_none);
        let all = self.comparison.sightings.len();
        let first = (0..all).find(failed).unwrap_or_default();
        let row = self.comparison.sightings[first].row;
        CalibrationError::NotSimulated {
            failed: (0..all).filter(failed).count(),
            rows: all,
            trial: self.comparison.recordings.joined.trial[row],
            time_s: self.comparison.recordings.joined.time_s[row],
        }
    }

    /// A step that lowers the weighted sum of squares; `None` when there is none of which the
    /// linear model expects `least_m2`.
    fn improved(&self, here: &Optimum, damping: &mut f64, least_m2: f64) -> Option<AcceptedStep> {
        let (normal, gradient) = self.normal(here);
        let free = self.free(here, &gradient);
        if free.is_empty() {
            return None;
        }
        let promising = |damping: f64| {
            let x = self.damped_step(here, (&normal, &gradient), &free, damping)?;
            let change = DVector::from_fn(x.len(), |k, _| x[k] - here.x[k]);
            let expected = -change.dot(&(2.0 * &gradient + &normal * &change));
            (expected >= least_m2).then_some((x, expected))
        };
        // The damping of an earlier step may leave this one too short.
        while *damping > MIN_DAMPING && promising(*damping).is_none() {
            *damping *= 0.2;
        }
        let accepted = longest(damping, |damping| {
            let (x, expected) = promising(damping)?;
            let positions = self.comparison.positions(&self.at(&x)?);
            let gain = self.gain(here, &x, &positions).filter(|&gain| gain >= 0.0)?;
            Some(AcceptedStep { x, positions, gain, expected })
        });
        // Bounds may undo the whole step.
        accepted.filter(|step| step.x != here.x)
    }

    /// Half the second derivative and half the gradient of the weighted sum of squares, priors
    /// included.
    pub(crate) fn normal(&self, here: &Optimum) -> (DMatrix<f64>, DVector<f64>) {
        let mut weighted = here.slopes.clone();
        for (index, &weight) in here.weights.iter().enumerate() {
            weighted.rows_mut(3 * index, 3).scale_mut(weight);
        }
        let mut normal = weighted.tr_mul(&here.slopes);
        let mut gradient = weighted.tr_mul(&here.residual_m);
        for (k, number) in self.numbers.iter().enumerate() {
            if let Some(deviation) = number.prior {
                // Squares are in m², so a prior counts in variances of one coordinate.
                let weight = here.variance_m2 / (deviation * deviation);
                normal[(k, k)] += weight;
                gradient[k] += weight * here.x[k];
            }
        }
        (normal, gradient)
    }

    /// By how much an undamped step would lower the weighted sum of squares if the model were
    /// linear.
    fn expected_gain(&self, here: &Optimum) -> f64 {
        let (normal, gradient) = self.normal(here);
        let free = self.free(here, &gradient);
        let part = DMatrix::from_fn(free.len(), free.len(), |row, column| {
            normal[(free[row], free[column])]
        });
        let right = DVector::from_fn(free.len(), |row, _| gradient[free[row]]);
        Cholesky::new(part).map_or(f64::INFINITY, |factor| factor.solve(&right).dot(&right))
    }

    /// Numbers that are not held at their bound.
    fn free(&self, here: &Optimum, gradient: &DVector<f64>) -> Vec<usize> {
        // Active set: at its bound a number is free only if the gradient leads inwards.
        let held = |k: usize| here.x[k] <= self.numbers[k].low() && gradient[k] >= 0.0;
        (0..here.x.len()).filter(|&k| !held(k) && gradient[k] != 0.0).collect()
    }

    /// The coordinates after a damped step of the free numbers, within their bounds.
    fn damped_step(
        &self,
        here: &Optimum,
        (normal, gradient): (&DMatrix<f64>, &DVector<f64>),
        free: &[usize],
        damping: f64,
    ) -> Option<Vec<f64>> {
        let part = DMatrix::from_fn(free.len(), free.len(), |row, column| {
            let entry = normal[(free[row], free[column])];
            // Marquardt's scaling: damping relative to the diagonal does not depend on units.
            if row == column { entry * (1.0 + damping) } else { entry }
        });
        let right = DVector::from_fn(free.len(), |row, _| -gradient[free[row]]);
        let step = Cholesky::new(part)?.solve(&right);
        let excess = |(&k, step): (&usize, &f64)| step.abs() / self.numbers[k].longest_step();
        // The whole step is shortened, so that its direction stays.
        let shorten = free.iter().zip(step.iter()).map(excess).fold(1.0, f64::max);
        let mut x = here.x.clone();
        for (&k, step) in free.iter().zip(step.iter()) {
            x[k] = (x[k] + step / shorten).max(self.numbers[k].low());
        }
        Some(x)
    }

    /// By how much the weighted sum of squares is lower at `x`, over the sightings that have a
    /// solution at both; `None` when too many have lost theirs.
    fn gain(&self, here: &Optimum, x: &[f64], positions: &Positions) -> Option<f64> {
        let solved = here.positions.iter().filter(|at| at.is_some()).count();
        let both = |index: usize| here.positions[index].is_some() && positions[index].is_some();
        let kept = (0..positions.len()).filter(|&index| both(index)).count();
        // A step must not win by losing the rows that fit worst.
        if (solved - kept) as f64 > MAX_LOST_SHARE * solved as f64 {
            return None;
        }
        let there = self.residual_m(positions);
        let square =
            |residual: &DVector<f64>, index: usize| residual.rows(3 * index, 3).norm_squared();
        let lower = |index: usize| {
            here.weights[index] * (square(&here.residual_m, index) - square(&there, index))
        };
        let data: f64 = (0..positions.len()).filter(|&index| both(index)).map(lower).sum();
        let prior = |(k, number): (usize, &FitNumber)| {
            number.prior.map_or(0.0, |deviation| {
                (here.x[k] * here.x[k] - x[k] * x[k]) / (deviation * deviation)
            })
        };
        let priors: f64 = self.numbers.iter().enumerate().map(prior).sum();
        let gain = data + here.variance_m2 * priors;
        gain.is_finite().then_some(gain)
    }
}

impl Optimum {
    /// Root mean square distance between simulated and measured points, metres.
    pub(crate) fn rms_m(&self) -> f64 {
        let solved = self.positions.iter().filter(|at| at.is_some()).count();
        (self.residual_m.norm_squared() / solved.max(1) as f64).sqrt()
    }
}
