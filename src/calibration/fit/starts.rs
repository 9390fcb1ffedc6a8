//! Several starts: cheap fits to a few rows decide where the fit to all rows begins.

use rand::RngExt;

use super::optimum::{CONVERGED, CalibrationProblem, Optimum, ROUGHLY_CONVERGED};
use crate::base::Seed;
use crate::calibration::error::CalibrationError;

/// Sightings of the fit that begins that to all rows.
const SOME: usize = 200;
/// Sightings of the cheap fits, and their steps.
const FEW: usize = 60;
const CHEAP_STEPS: usize = 8;
/// As [`ROUGHLY_CONVERGED`], for the first fit to some poses of a robot with memory: it goes another
/// way through fewer of them, so that their optimum is not that of all.
const NEAR_ENOUGH: f64 = 10.0;
/// Further starts, and their spread in coordinates: a factor of two, or one and a half units.
const STARTS: u64 = 4;
const SPREAD: f64 = 0.7;
/// Steps of the fit to all rows.
pub(crate) const MAX_STEPS: usize = 60;
/// Another start is taken when it leaves less than this share of the sum of squares.
const BETTER: f64 = 0.9;

/// The best fit, and whether another start than the given one led to it. Other starts are only
/// tried when `is_good` says that the given one leaves more than noise.
pub(crate) fn best(
    problem: &CalibrationProblem,
    start: &[f64],
    is_good: &dyn Fn(&Optimum) -> bool,
) -> Result<(Optimum, bool), CalibrationError> {
    let near = coarse(problem, start);
    // 1. From the model's own values, which are usually near. Where a section begins to slip, what
    //    a memory says has a kink: beyond a standard error a derivative promises what is not there.
    let converged = if problem.comparison.remembers { ROUGHLY_CONVERGED } else { CONVERGED };
    let first = problem.fit(&near, MAX_STEPS, converged)?;
    // A few rows tell nothing of a memory, whose paths they cut short.
    if is_good(&first) || !problem.comparison.independent {
        return Ok((first, false));
    }
    // 2. More than noise remains: look for another minimum on a few rows.
    let Some(start) = rival(problem, &first) else { return Ok((first, false)) };
    let near = coarse(problem, &start);
    match problem.fit(&near, MAX_STEPS, CONVERGED) {
        Ok(other) if other.rms_m() < first.rms_m() => Ok((other, true)),
        _ => Ok((first, false)),
    }
}

/// A start for the fit to all rows from a fit to some of them, where rows are poses and many.
fn coarse(problem: &CalibrationProblem, start: &[f64]) -> Vec<f64> {
    let wanted = SOME.max(8 * problem.numbers.len());
    if !problem.comparison.at_rest || problem.comparison.sightings.len() < 3 * wanted {
        return start.to_vec();
    }
    let (comparison, _) = problem.comparison.thinned(wanted);
    let converged = if comparison.remembers { NEAR_ENOUGH } else { ROUGHLY_CONVERGED };
    let part = CalibrationProblem { comparison: &comparison, ..*problem };
    part.fit(start, MAX_STEPS, converged).map_or_else(|_| start.to_vec(), |optimum| optimum.x)
}

/// Where a cheap fit from another start came clearly lower than `first`.
fn rival(problem: &CalibrationProblem, first: &Optimum) -> Option<Vec<f64>> {
    let few = FEW.max(2 * problem.numbers.len());
    let (comparison, _) = problem.comparison.thinned(few);
    let cheap = CalibrationProblem { comparison: &comparison, ..*problem };
    // The same few rows and steps for both: only then their errors compare.
    let reached = cheap.fit(&first.x, CHEAP_STEPS, ROUGHLY_CONVERGED).ok()?.rms_m().powi(2);
    let rivals = (0..STARTS).filter_map(|number| {
        // A fixed seed: the same recording gives the same numbers.
        let mut random = Seed(0).child("calibration start").index(number).rng();
        let drawn = problem
            .numbers
            .iter()
            .map(|number| (SPREAD * random.random_range(-1.0..1.0)).max(number.low()));
        let start: Vec<f64> = drawn.collect();
        let there = cheap.fit(&start, CHEAP_STEPS, ROUGHLY_CONVERGED).ok()?;
        Some((there.rms_m().powi(2), there.x))
    });
    let winner = rivals
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(square_m2, _)| *square_m2 < BETTER * reached);
    winner.map(|(_, start)| start)
}
