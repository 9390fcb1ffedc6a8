//! Noise of the measurement as far as the recording tells it, and whether the model leaves more
//! than that.

use nalgebra::DVector;

use super::comparison::{Comparison, Positions};
use crate::base::distance_m;
use crate::math::distribution::f_above;
use crate::math::summary::quantile;

/// Least number of pairs for an estimate.
const MIN_PAIRS: usize = 20;
/// A point that the model moves by less than this from one row to the next rests, metres.
const RESTS_M: f64 = 2e-5;
/// Largest change of a command that is held, metres or newtons.
const HELD: f64 = 2e-5;
/// Median of χ² with three degrees of freedom.
const MEDIAN_CHI_SQUARED: f64 = 2.365_974;
/// Degrees of freedom that a pair gives a variance estimated by the median: three coordinates,
/// efficiency 37 %, shared rows.
const FREEDOM_OF_PAIR: f64 = 0.7;
/// Probability by noise alone below which a misfit is told.
const SIGNIFICANT: f64 = 1e-3;
/// Ratio of the errors below which a misfit does not matter.
const MIN_RATIO: f64 = 1.15;
/// Errors below this are the solver's, metres.
const SOLVER_M: f64 = 1e-6;

/// Noise of the measurement.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NoiseEstimate {
    /// Root mean square distance that noise makes, metres.
    pub(crate) rms_m: f64,
    /// Pairs of rows behind it.
    pub(crate) pairs: usize,
    /// Where it is from.
    pub(crate) from: &'static str,
}

/// The noise of the recording: from pairs of rows at rest, or else from the change of the error
/// from one row to the next (von Neumann 1941), which is an upper bound. `None` for too few pairs.
pub(crate) fn noise(
    comparison: &Comparison,
    residual_m: &DVector<f64>,
    positions: &Positions,
) -> Option<NoiseEstimate> {
    let pairs = pairs(comparison, positions);
    let difference = |&(a, b): &(usize, usize)| {
        (residual_m.rows(3 * a, 3) - residual_m.rows(3 * b, 3)).norm_squared()
    };
    let rests = |&(a, b): &(usize, usize)| match (positions[a], positions[b]) {
        (Some(before), Some(after)) => {
            is_held(comparison, a, b) && distance_m(&before, &after) < RESTS_M
        }
        _ => false,
    };
    let at_rest: Vec<(usize, usize)> = pairs.iter().copied().filter(rests).collect();
    let of = |pairs: &[(usize, usize)], from: &'static str| {
        let squares: Vec<f64> = pairs.iter().map(difference).collect();
        // A difference has twice the variance: over three axes 3σ² is 1.5 · median / (median of
        // χ²). The median ignores outliers.
        let rms_m = (1.5 * quantile(&squares, 0.5) / MEDIAN_CHI_SQUARED).sqrt();
        (pairs.len() >= MIN_PAIRS).then_some(NoiseEstimate { rms_m, pairs: pairs.len(), from })
    };
    of(&at_rest, "rows at rest")
        .or_else(|| of(&pairs, "the change of the error from row to row, an upper bound"))
}

/// Whether the commands of two sightings are the same, up to the steps of an encoder.
fn is_held(comparison: &Comparison, a: usize, b: usize) -> bool {
    let command =
        |index: usize| comparison.recordings.joined.commands.row(comparison.sightings[index].row);
    command(a).iter().zip(command(b)).all(|(before, after)| (after - before).abs() < HELD)
}

/// Sightings of one point in consecutive rows of a trial.
fn pairs(comparison: &Comparison, positions: &Positions) -> Vec<(usize, usize)> {
    let mut last: Vec<Option<usize>> = vec![None; comparison.markers.len()];
    let mut pairs = Vec::new();
    for (index, sighting) in comparison.sightings.iter().enumerate() {
        let before = last[sighting.marker].replace(index);
        let follows = |before: &usize| {
            let row = comparison.sightings[*before].row;
            // A gap or a new trial may hide a motion.
            row + 1 == sighting.row
                && comparison.recordings.joined.trial[row]
                    == comparison.recordings.joined.trial[sighting.row]
        };
        if let Some(before) = before.filter(follows)
            && positions[before].is_some()
            && positions[index].is_some()
        {
            pairs.push((before, index));
        }
    }
    pairs
}

/// How much more than noise a model leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Misfit {
    /// Error of the model over that of noise.
    pub(crate) ratio: f64,
    /// Probability of this ratio or more from noise alone.
    pub(crate) p_value: f64,
}

/// The misfit of a model that leaves `rms_m` (robust, so that outliers do not count) over `freedom`
/// degrees of freedom; `None` when noise explains it.
pub(crate) fn misfit(noise: &NoiseEstimate, rms_m: f64, freedom: f64) -> Option<Misfit> {
    if rms_m < SOLVER_M {
        return None;
    }
    let ratio = rms_m / noise.rms_m.max(SOLVER_M);
    // F-test of two variances; each side has its own degrees of freedom.
    let p_value = f_above(ratio * ratio, freedom, FREEDOM_OF_PAIR * noise.pairs as f64);
    // Of many rows even a negligible misfit is significant.
    (p_value < SIGNIFICANT && ratio > MIN_RATIO).then_some(Misfit { ratio, p_value })
}
