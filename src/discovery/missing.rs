//! Is anything missing? Where a model lacks something, what is left of one trial can be foretold from the others: the
//! same circumstances leave the same residual. Noise cannot be foretold. A regression (kernel ridge) on circumstances is
//! fitted to all trials but one and asked about that one; its success is compared with that under random signs of blocks
//! of samples, which noise alone would not mind (a permutation test; Good, Permutation Tests, ch. 2). Blocks are whole
//! trials, or parts of them where there are few; noise that is correlated over a few samples does not mind either.

use std::ops::Range;

use nalgebra::{Cholesky, DMatrix, DVector};
use rand::RngExt;

use super::features::Circumstances;
use super::samples::{Samples, rms_m};
use crate::base::Seed;
use crate::data::findings::MissingTest;
use crate::math::distribution::normal_above;

/// On what a residual depends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pattern {
    /// Where the robot is.
    Pose,
    /// How it got there.
    History,
    /// How long the trial has lasted.
    Time,
    /// That it is there at all.
    Constant,
}

/// The test's result, and what share of the residual's squares each pattern foretells, the best first.
#[derive(Clone, Debug)]
pub(super) struct Missing {
    pub(super) test: MissingTest,
    pub(super) foretold: Vec<(Pattern, f64)>,
}

/// Blocks with signs of their own at least.
const FEWEST_BLOCKS: usize = 12;
/// Random signs that are compared with.
const DRAWS: usize = 400;
/// Variance of what is not foretold, over that of what is.
const RIDGE: f64 = 3.0;

/// Tests whether `residual` (metres, three numbers a sample) holds more than noise.
pub(super) fn missing(samples: &Samples, around: &[Circumstances], residual: &[f64], seed: Seed) -> Missing {
    let ranges = samples.ranges();
    let blocks = blocks(&ranges);
    let patterns = [Pattern::Constant, Pattern::Pose, Pattern::History, Pattern::Time];
    let tables: Vec<Table> =
        patterns.iter().map(|&p| Table::new(&kernel(p, around), &ranges, &blocks, residual)).collect();
    let mut random = seed.child("signs").rng();
    let flipped: Vec<Vec<f64>> = (0..DRAWS)
        .map(|_| {
            let signs: Vec<[f64; 3]> = blocks
                .iter()
                .map(|_| std::array::from_fn(|_| if random.random_range(0..2) == 0 { -1.0 } else { 1.0 }))
                .collect();
            tables.iter().map(|table| table.success(&signs)).collect()
        })
        .collect();
    let plain = vec![[1.0; 3]; blocks.len()];
    // The best of the patterns' successes, each in its own standard deviations, and how often chance does as well.
    let moments: Vec<(f64, f64)> = (0..tables.len()).map(|k| moments(flipped.iter().map(|draw| draw[k]))).collect();
    let best = |successes: &[f64]| {
        let scaled = successes.iter().zip(&moments).map(|(value, (mean, deviation))| (value - mean) / deviation);
        scaled.fold(f64::NEG_INFINITY, f64::max)
    };
    let observed: Vec<f64> = tables.iter().map(|table| table.success(&plain)).collect();
    let height = best(&observed);
    let above = flipped.iter().filter(|draw| best(draw) >= height).count();
    let counted = (above + 1) as f64 / (DRAWS + 1) as f64;
    // Beyond what so many draws can show, the tail of a normal law.
    let p_value = if above == 0 { counted.min(tables.len() as f64 * normal_above(height)) } else { counted };
    let squares = residual.iter().map(|r| r * r).sum::<f64>().max(f64::MIN_POSITIVE);
    let mut foretold: Vec<(Pattern, f64)> =
        patterns.into_iter().zip(&tables).map(|(pattern, table)| (pattern, table.foretold / squares)).collect();
    foretold.sort_by(|a, b| b.1.total_cmp(&a.1));
    let most_m2 = foretold[0].1 * squares / samples.len().max(1) as f64;
    Missing { test: MissingTest { rms_m: rms_m(residual), foretold_m: most_m2.sqrt(), p_value }, foretold }
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

/// Products between what was left in each block and what each block of another trial foretells there.
struct Table {
    /// For each axis: block foretold × block foretelling.
    products: [DMatrix<f64>; 3],
    /// Fall of the sum of squares by what is foretold, m²; not below zero.
    foretold: f64,
}

impl Table {
    fn new(kernel: &DMatrix<f64>, trials: &[Range<usize>], blocks: &[Range<usize>], residual: &[f64]) -> Table {
        let count = blocks.len();
        let mut products: [DMatrix<f64>; 3] = std::array::from_fn(|_| DMatrix::zeros(count, count));
        let mut foretold = 0.0;
        for there in trials {
            let others: Vec<usize> =
                trials.iter().filter(|trial| *trial != there).flat_map(|trial| trial.clone()).collect();
            let mut known = DMatrix::from_fn(others.len(), others.len(), |i, j| kernel[(others[i], others[j])]);
            (0..others.len()).for_each(|k| known[(k, k)] += RIDGE);
            let Some(factor) = Cholesky::new(known) else { continue };
            let cross = DMatrix::from_fn(others.len(), there.len(), |i, j| kernel[(others[i], there.start + j)]);
            let weights = factor.solve(&cross);
            let inside = |block: &Range<usize>| there.contains(&block.start);
            for axis in 0..3 {
                let part =
                    |rows: Range<usize>| DVector::from_iterator(rows.len(), rows.map(|row| residual[3 * row + axis]));
                let left = part(there.clone());
                let mut sum = DVector::zeros(there.len());
                for (other, block) in blocks.iter().enumerate().filter(|(_, block)| !inside(block)) {
                    let first = others.partition_point(|&row| row < block.start);
                    let told = weights.rows(first, block.len()).tr_mul(&part(block.clone()));
                    for (own, here) in blocks.iter().enumerate().filter(|(_, block)| inside(block)) {
                        let (start, length) = (here.start - there.start, here.len());
                        products[axis][(own, other)] = left.rows(start, length).dot(&told.rows(start, length));
                    }
                    sum += told;
                }
                foretold += 2.0 * left.dot(&sum) - sum.norm_squared();
            }
        }
        Table { products, foretold: foretold.max(0.0) }
    }

    /// Agreement of what was left with what was foretold, m², each trial's residual with a sign.
    fn success(&self, signs: &[[f64; 3]]) -> f64 {
        let one = |axis: usize| -> f64 {
            let table = &self.products[axis];
            let term = |i: usize, j: usize| signs[i][axis] * signs[j][axis] * table[(i, j)];
            (0..table.nrows()).map(|i| (0..table.ncols()).map(|j| term(i, j)).sum::<f64>()).sum()
        };
        (0..3).map(one).sum()
    }
}

/// How alike the circumstances of two samples are, from 0 to 1.
fn kernel(pattern: Pattern, around: &[Circumstances]) -> DMatrix<f64> {
    let features: Vec<Vec<f64>> = around
        .iter()
        .map(|at| match pattern {
            Pattern::Constant => Vec::new(),
            Pattern::Pose => at.tip_m.iter().chain(&at.command).copied().collect(),
            Pattern::History => {
                let within = at.command.iter().zip(&at.largest).map(|(now, most)| most - now);
                at.change.iter().chain(&at.change_before).copied().chain(at.moved_m).chain(within).collect()
            }
            Pattern::Time => vec![at.time_s],
        })
        .collect();
    let width = features.first().map_or(0, Vec::len);
    let scale: Vec<f64> = (0..width)
        .map(|k| {
            let column: Vec<f64> = features.iter().map(|row| row[k]).collect();
            crate::math::summary::standard_deviation(&column).max(1e-12) * (width as f64).sqrt()
        })
        .collect();
    let distance = |a: &[f64], b: &[f64]| -> f64 {
        a.iter().zip(b).zip(&scale).map(|((a, b), scale)| ((a - b) / scale).powi(2)).sum()
    };
    DMatrix::from_fn(around.len(), around.len(), |i, j| (-0.5 * distance(&features[i], &features[j])).exp())
}
