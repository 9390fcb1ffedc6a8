//! Cross-trial test: can the residual of one trial be predicted from the others? Model errors
//! repeat under the same conditions; noise does not. A kernel ridge regression on covariates is
//! fitted to all trials but one and predicts that one. Its success is compared with that under
//! random signs of blocks of samples (permutation test; Good, Permutation Tests, ch. 2). Blocks are
//! trials, or parts of trials if there are few, so noise correlated over a few samples is
//! admissible.

use std::ops::Range;

use rand::RngExt;

use super::kernel_ridge::{BinnedSamples, CrossPrediction, ResidualPattern};
use crate::base::Seed;
use crate::data::findings::MissingTest;
use crate::discovery::recording::covariates::Covariates;
use crate::discovery::recording::samples::{Samples, rms_m};
use crate::math::distribution::normal_above;

/// Test result, and the share of squares that each pattern predicts, best first.
#[derive(Clone, Debug)]
pub(crate) struct CrossTrialTest {
    pub(crate) test: MissingTest,
    pub(crate) foretold: Vec<(ResidualPattern, f64)>,
}

/// Minimum number of blocks.
const MIN_BLOCKS: usize = 12;
/// Minimum number of sign draws.
const MIN_DRAWS: usize = 400;
/// Maximum number of sign draws, so that a chance of one in a thousand is observed several times.
const MAX_DRAWS: usize = 4000;
/// Draws stop after this many successes by chance (sequential Monte Carlo; Besag & Clifford,
/// Biometrika 78, 1991).
const MAX_CHANCE_SUCCESSES: usize = 20;

/// Tests whether `residual` (metres, three values a sample) is noise.
pub(crate) fn test_cross_trial(
    samples: &Samples,
    covariates: &[Covariates],
    residual: &[f64],
    seed: Seed,
) -> CrossTrialTest {
    let points = BinnedSamples::new(&samples.ranges(), covariates, residual);
    let blocks = blocks(&points.ranges);
    let patterns = [
        ResidualPattern::Constant,
        ResidualPattern::Pose,
        ResidualPattern::History,
        ResidualPattern::Time,
    ];
    let tables: Vec<CrossPrediction> =
        patterns.iter().map(|&pattern| CrossPrediction::new(pattern, &points, &blocks)).collect();
    let mut random = seed.child("signs").rng();
    let mut drawn = || -> Vec<f64> {
        // Under the null hypothesis noise is symmetric, so signs of whole blocks may be flipped.
        let mut sign = || if random.random_range(0..2) == 0 { -1.0 } else { 1.0 };
        let signs: Vec<[f64; 3]> = blocks.iter().map(|_| std::array::from_fn(|_| sign())).collect();
        tables.iter().map(|table| table.success(&signs)).collect()
    };
    // 1. Draws that give each pattern the mean and the deviation of its success by chance.
    let first: Vec<Vec<f64>> = (0..MIN_DRAWS).map(|_| drawn()).collect();
    // Test statistic: the largest standardised success over the patterns.
    let moments: Vec<(f64, f64)> =
        (0..tables.len()).map(|k| moments(first.iter().map(|draw| draw[k]))).collect();
    let best = |successes: &[f64]| {
        let scaled = successes
            .iter()
            .zip(&moments)
            .map(|(value, (mean, deviation))| (value - mean) / deviation);
        scaled.fold(f64::NEG_INFINITY, f64::max)
    };
    // 2. The observed success is that without any flip.
    let unsigned = vec![[1.0; 3]; blocks.len()];
    let observed: Vec<f64> = tables.iter().map(|table| table.success(&unsigned)).collect();
    let height = best(&observed);
    // 3. Draws until enough do as well by chance.
    let mut draws = MIN_DRAWS;
    let mut above = first.iter().filter(|draw| best(draw) >= height).count();
    while above < MAX_CHANCE_SUCCESSES && draws < MAX_DRAWS {
        draws += 1;
        above += usize::from(best(&drawn()) >= height);
    }
    // The observed data count as one draw, so that p is never zero.
    let counted = (above + 1) as f64 / (draws + 1) as f64;
    // Below the resolution of the draws: tail of the normal distribution.
    let p_value =
        if above == 0 { counted.min(tables.len() as f64 * normal_above(height)) } else { counted };
    let squares = residual.iter().map(|r| r * r).sum::<f64>().max(f64::MIN_POSITIVE);
    let mut foretold: Vec<(ResidualPattern, f64)> = patterns
        .into_iter()
        .zip(&tables)
        .map(|(pattern, table)| (pattern, (table.foretold / squares).min(1.0)))
        .collect();
    foretold.sort_by(|a, b| b.1.total_cmp(&a.1));
    let foretold_m2 = foretold[0].1 * squares / samples.len().max(1) as f64;
    CrossTrialTest {
        test: MissingTest { rms_m: rms_m(residual), foretold_m: foretold_m2.sqrt(), p_value },
        foretold,
    }
}

fn moments(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let values: Vec<f64> = values.collect();
    let deviation = crate::math::summary::standard_deviation(&values);
    (crate::math::summary::mean(&values), deviation.max(f64::MIN_POSITIVE))
}

/// Blocks of samples with a common sign: at least [`MIN_BLOCKS`].
fn blocks(ranges: &[Range<usize>]) -> Vec<Range<usize>> {
    // Few trials allow few sign patterns, 2^blocks, so they are divided.
    let parts = MIN_BLOCKS.div_ceil(ranges.len().max(1));
    let cut = |range: &Range<usize>| -> Vec<Range<usize>> {
        let at = |part: usize| range.start + range.len() * part / parts;
        (0..parts).map(|part| at(part)..at(part + 1)).filter(|block| !block.is_empty()).collect()
    };
    ranges.iter().flat_map(cut).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::discovery::recording::covariates::sample_covariates;
    use crate::discovery::recording::samples::{Sample, white_noise};

    const NOISE_M: f64 = 5e-4;

    /// Eight trials on a circle: noise, plus a residual of amplitude `more_m` that depends on the
    /// position.
    fn tested(samples: usize, more_m: f64) -> CrossTrialTest {
        let alike = Samples::alike(8, samples);
        let angle = |sample: &Sample| {
            TAU * (sample.row as f64 / samples as f64 + 0.3 * sample.trial as f64)
        };
        let place = |sample: &Sample| [0.05 * angle(sample).cos(), 0.05 * angle(sample).sin(), 0.2];
        let simulated_m: Vec<f64> = alike.rows.iter().flat_map(place).collect();
        let mut noise = white_noise(NOISE_M, 1);
        let left = |sample: &Sample| [noise() + more_m * angle(sample).cos(), noise(), noise()];
        let residual_m: Vec<f64> = alike.rows.iter().flat_map(left).collect();
        test_cross_trial(&alike, &sample_covariates(&alike, &simulated_m), &residual_m, Seed(0))
    }

    #[test]
    fn what_depends_on_the_pose_is_foretold_of_few_samples_and_of_many() {
        for samples in [50, 500] {
            let none = tested(samples, 0.0).test;
            assert!(none.p_value > 0.01, "{samples}: {none:?}");
            let found = tested(samples, 2.0 * NOISE_M);
            assert!(found.test.p_value < 1e-3, "{samples}: {:?}", found.test);
            // Two parts of the squares are due to the pose, three to noise. Time predicts the pose
            // only within a trial.
            let share = |of: ResidualPattern| {
                found.foretold.iter().find(|(pattern, _)| *pattern == of).unwrap().1
            };
            assert!(
                (share(ResidualPattern::Pose) - 0.4).abs() < 0.06,
                "{samples}: {:?}",
                found.foretold
            );
            assert!(
                share(ResidualPattern::Time).max(share(ResidualPattern::Constant)) < 0.1,
                "{samples}: {:?}",
                found.foretold
            );
            let foretold_m = 2.0_f64.sqrt() * NOISE_M;
            assert!(
                (found.test.foretold_m / foretold_m - 1.0).abs() < 0.1,
                "{samples}: {:?}",
                found.test
            );
        }
    }
}
