//! Kernel ridge regression of residuals on covariates, with prediction of each trial from the
//! others (Hastie, Tibshirani & Friedman, The Elements of Statistical Learning, section 5.8).

use std::ops::Range;

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::discovery::recording::covariates::Covariates;

/// What a residual depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ResidualPattern {
    /// Position and command.
    Pose,
    /// Motion history.
    History,
    /// Time in the trial.
    Time,
    /// A constant.
    Constant,
}

/// Ratio of noise variance to signal variance.
const RIDGE: f64 = 3.0;
/// Beyond this number of samples, consecutive ones are averaged: the cost grows with the cube.
const MAX_POINTS: usize = 1200;

/// Beyond this number of trials, several are predicted together.
const MAX_GROUPS: usize = 12;

/// Samples, or means of consecutive samples if there are many.
pub(crate) struct BinnedSamples {
    /// Points of each trial or group of trials.
    pub(crate) ranges: Vec<Range<usize>>,
    /// Covariates of each point, from its middle sample.
    covariates: Vec<Covariates>,
    /// Residual, metres, three values a point.
    residual: Vec<f64>,
    /// Mean number of samples a point.
    samples_each: f64,
}

impl BinnedSamples {
    pub(crate) fn new(
        trials: &[Range<usize>],
        covariates: &[Covariates],
        residual: &[f64],
    ) -> BinnedSamples {
        let together = covariates.len().div_ceil(MAX_POINTS).max(1);
        let mut points = BinnedSamples {
            ranges: Vec::new(),
            covariates: Vec::new(),
            residual: Vec::new(),
            samples_each: 1.0,
        };
        for trial in trials {
            let first = points.covariates.len();
            for start in trial.clone().step_by(together) {
                let rows = start..trial.end.min(start + together);
                // Commands and history cannot be averaged; the middle sample stands for all.
                points.covariates.push(covariates[start + rows.len() / 2].clone());
                let mean = |axis: usize| {
                    rows.clone().map(|row| residual[3 * row + axis]).sum::<f64>()
                        / rows.len() as f64
                };
                points.residual.extend((0..3).map(mean));
            }
            points.ranges.push(first..points.covariates.len());
        }
        let each = points.ranges.len().div_ceil(MAX_GROUPS).max(1);
        points.ranges = points
            .ranges
            .chunks(each)
            .map(|group| group[0].start..group[group.len() - 1].end)
            .collect();
        points.samples_each = covariates.len() as f64 / points.covariates.len().max(1) as f64;
        points
    }
}

/// Products of the residual of each block and its prediction by blocks of other trials.
pub(crate) struct CrossPrediction {
    /// For each axis: predicted block × predicting block.
    products: [DMatrix<f64>; 3],
    /// Decrease of the sum of squares by the prediction, m², at least zero.
    pub(crate) foretold: f64,
}

impl CrossPrediction {
    /// Predictions of each block by `pattern` from other trials.
    pub(crate) fn new(
        pattern: ResidualPattern,
        points: &BinnedSamples,
        blocks: &[Range<usize>],
    ) -> CrossPrediction {
        let kernel = kernel(pattern, &points.covariates);
        let (trials, residual) = (&points.ranges, &points.residual);
        let count = blocks.len();
        let mut products: [DMatrix<f64>; 3] = std::array::from_fn(|_| DMatrix::zeros(count, count));
        let mut foretold = 0.0;
        for there in trials {
            let others: Vec<usize> = trials
                .iter()
                .filter(|trial| *trial != there)
                .flat_map(|trial| trial.clone())
                .collect();
            // Ridge regression on all other trials (K + λI).
            let mut gram =
                DMatrix::from_fn(others.len(), others.len(), |i, j| kernel[(others[i], others[j])]);
            (0..others.len()).for_each(|k| gram[(k, k)] += RIDGE);
            let Some(factor) = Cholesky::new(gram) else { continue };
            let cross = DMatrix::from_fn(others.len(), there.len(), |i, j| {
                kernel[(others[i], there.start + j)]
            });
            // The weights depend on covariates alone, so that flipped signs need no new solve.
            let weights = factor.solve(&cross);
            let inside = |block: &Range<usize>| there.contains(&block.start);
            for axis in 0..3 {
                let part = |rows: Range<usize>| {
                    DVector::from_iterator(rows.len(), rows.map(|row| residual[3 * row + axis]))
                };
                let measured = part(there.clone());
                let mut sum = DVector::zeros(there.len());
                for (other, block) in blocks.iter().enumerate().filter(|(_, block)| !inside(block))
                {
                    // A block lies within one trial, so its rows are contiguous among `others`.
                    let first = others.partition_point(|&row| row < block.start);
                    let predicted = weights.rows(first, block.len()).tr_mul(&part(block.clone()));
                    for (row, here) in blocks.iter().enumerate().filter(|(_, block)| inside(block))
                    {
                        let (start, length) = (here.start - there.start, here.len());
                        products[axis][(row, other)] =
                            measured.rows(start, length).dot(&predicted.rows(start, length));
                    }
                    sum += predicted;
                }
                // |r|² − |r − r̂|²: negative where the prediction is worse than none.
                foretold += 2.0 * measured.dot(&sum) - sum.norm_squared();
            }
        }
        CrossPrediction { products, foretold: points.samples_each * foretold.max(0.0) }
    }

    /// Agreement of residual and prediction, m², with signs of the blocks.
    pub(crate) fn success(&self, signs: &[[f64; 3]]) -> f64 {
        let one = |axis: usize| -> f64 {
            let table = &self.products[axis];
            let term = |i: usize, j: usize| signs[i][axis] * signs[j][axis] * table[(i, j)];
            (0..table.nrows()).map(|i| (0..table.ncols()).map(|j| term(i, j)).sum::<f64>()).sum()
        };
        (0..3).map(one).sum()
    }
}

/// Kernel matrix of the covariates, from 0 to 1.
fn kernel(pattern: ResidualPattern, covariates: &[Covariates]) -> DMatrix<f64> {
    let features: Vec<Vec<f64>> = covariates
        .iter()
        .map(|at| match pattern {
            ResidualPattern::Constant => Vec::new(),
            ResidualPattern::Pose => at.position_m.iter().chain(&at.command).copied().collect(),
            ResidualPattern::History => {
                // Friction and hysteresis depend on how far the last reversal is behind.
                let within = at.command.iter().zip(&at.largest).map(|(now, largest)| largest - now);
                at.change
                    .iter()
                    .chain(&at.change_before)
                    .copied()
                    .chain(at.moved_m)
                    .chain(within)
                    .collect()
            }
            ResidualPattern::Time => vec![at.time_s],
        })
        .collect();
    let width = features.first().map_or(0, Vec::len);
    let scale: Vec<f64> = (0..width)
        .map(|k| {
            let column: Vec<f64> = features.iter().map(|row| row[k]).collect();
            // The typical distance is one, whatever the number of covariates.
            crate::math::summary::standard_deviation(&column).max(1e-12) * (width as f64).sqrt()
        })
        .collect();
    let distance = |a: &[f64], b: &[f64]| -> f64 {
        a.iter().zip(b).zip(&scale).map(|((a, b), scale)| ((a - b) / scale).powi(2)).sum()
    };
    // The residual at one place of the body says nothing on that at another.
    DMatrix::from_fn(covariates.len(), covariates.len(), |i, j| {
        let is_same_place = covariates[i].point == covariates[j].point;
        if is_same_place { (-0.5 * distance(&features[i], &features[j])).exp() } else { 0.0 }
    })
}
