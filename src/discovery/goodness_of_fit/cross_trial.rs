//! Is anything missing? Where a model lacks something, what is left of one trial can be foretold from the others: the
//! same circumstances leave the same residual. Ar1Noise cannot be foretold. A regression (kernel ridge) on circumstances is
//! fitted to all trials but one and asked about that one; its success is compared with that under random signs of blocks
//! of samples, which noise alone would not mind (a permutation test; Good, Permutation Tests, ch. 2). Blocks are whole
//! trials, or parts of them where there are few; noise that is correlated over a few samples does not mind either.

use std::ops::Range;

use rand::RngExt;

use super::kernel_ridge::{BinnedSamples, CrossPrediction, ResidualPattern};
use crate::base::Seed;
use crate::data::findings::MissingTest;
use crate::discovery::recording::covariates::Covariates;
use crate::discovery::recording::samples::{Samples, rms_m};
use crate::math::distribution::normal_above;

/// The test's result, and what share of the residual's squares each pattern foretells, the best first.
#[derive(Clone, Debug)]
pub(crate) struct CrossTrialTest {
    pub(crate) test: MissingTest,
    pub(crate) foretold: Vec<(ResidualPattern, f64)>,
}

/// Blocks with signs of their own at least.
const FEWEST_BLOCKS: usize = 12;
/// Random signs that show how far chance goes, …
const DRAWS: usize = 400;
/// … and that are compared with at most: what does as well once in a thousand is to be seen several times, …
const MOST_DRAWS: usize = 4000;
/// … until so many have done as well (sequential Monte Carlo; Besag & Clifford, Biometrika 78, 1991).
const ENOUGH_ABOVE: usize = 20;

/// Tests whether `residual` (metres, three numbers a sample) holds more than noise.
pub(crate) fn test_cross_trial(
    samples: &Samples,
    covariates: &[Covariates],
    residual: &[f64],
    seed: Seed,
) -> CrossTrialTest {
    let points = BinnedSamples::new(&samples.ranges(), covariates, residual);
    let blocks = blocks(&points.ranges);
    let patterns = [ResidualPattern::Constant, ResidualPattern::Pose, ResidualPattern::History, ResidualPattern::Time];
    let tables: Vec<CrossPrediction> =
        patterns.iter().map(|&pattern| CrossPrediction::new(pattern, &points, &blocks)).collect();
    let mut random = seed.child("signs").rng();
    let mut drawn = || -> Vec<f64> {
        let mut sign = || if random.random_range(0..2) == 0 { -1.0 } else { 1.0 };
        let signs: Vec<[f64; 3]> = blocks.iter().map(|_| std::array::from_fn(|_| sign())).collect();
        tables.iter().map(|table| table.success(&signs)).collect()
    };
    let first: Vec<Vec<f64>> = (0..DRAWS).map(|_| drawn()).collect();
    // The best of the patterns' successes, each in its own standard deviations, and how often chance does as well.
    let moments: Vec<(f64, f64)> = (0..tables.len()).map(|k| moments(first.iter().map(|draw| draw[k]))).collect();
    let best = |successes: &[f64]| {
        let scaled = successes.iter().zip(&moments).map(|(value, (mean, deviation))| (value - mean) / deviation);
        scaled.fold(f64::NEG_INFINITY, f64::max)
    };
    let plain = vec![[1.0; 3]; blocks.len()];
    let observed: Vec<f64> = tables.iter().map(|table| table.success(&plain)).collect();
    let height = best(&observed);
    let mut draws = DRAWS;
    let mut above = first.iter().filter(|draw| best(draw) >= height).count();
    while above < ENOUGH_ABOVE && draws < MOST_DRAWS {
        draws += 1;
        above += usize::from(best(&drawn()) >= height);
    }
    let counted = (above + 1) as f64 / (draws + 1) as f64;
    // Beyond what so many draws can show, the tail of a normal law.
    let p_value = if above == 0 { counted.min(tables.len() as f64 * normal_above(height)) } else { counted };
    let squares = residual.iter().map(|r| r * r).sum::<f64>().max(f64::MIN_POSITIVE);
    let mut foretold: Vec<(ResidualPattern, f64)> = patterns
        .into_iter()
        .zip(&tables)
        .map(|(pattern, table)| (pattern, (table.foretold / squares).min(1.0)))
        .collect();
    foretold.sort_by(|a, b| b.1.total_cmp(&a.1));
    let most_m2 = foretold[0].1 * squares / samples.len().max(1) as f64;
    CrossTrialTest { test: MissingTest { rms_m: rms_m(residual), foretold_m: most_m2.sqrt(), p_value }, foretold }
}

fn moments(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let values: Vec<f64> = values.collect();
    let deviation = crate::math::summary::standard_deviation(&values);
    (crate::math::summary::mean(&values), deviation.max(f64::MIN_POSITIVE))
}

/// Blocks of samples whose signs are drawn together: at least [`FEWEST_BLOCKS`] of them.
fn blocks(ranges: &[Range<usize>]) -> Vec<Range<usize>> {
    let parts = FEWEST_BLOCKS.div_ceil(ranges.len().max(1));
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

    /// Eight trials of so many samples, each of which goes round a circle; what is left is noise and, on one side of it, so
    /// much more.
    fn tested(samples: usize, more_m: f64) -> CrossTrialTest {
        let alike = Samples::alike(8, samples);
        let angle = |sample: &Sample| TAU * (sample.row as f64 / samples as f64 + 0.3 * sample.trial as f64);
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
            // Of the squares, 2 are the pose's and 3 the noise's. Time is the pose's only within a trial.
            let share = |of: ResidualPattern| found.foretold.iter().find(|(pattern, _)| *pattern == of).unwrap().1;
            assert!((share(ResidualPattern::Pose) - 0.4).abs() < 0.06, "{samples}: {:?}", found.foretold);
            assert!(
                share(ResidualPattern::Time).max(share(ResidualPattern::Constant)) < 0.1,
                "{samples}: {:?}",
                found.foretold
            );
            let foretold_m = 2.0_f64.sqrt() * NOISE_M;
            assert!((found.test.foretold_m / foretold_m - 1.0).abs() < 0.1, "{samples}: {:?}", found.test);
        }
    }
}
