//! Least squares of what the model leaves on columns in groups, cross-validated over trials.
//! Nuisance parameters are part of every fit, at the price of their priors.

use std::ops::Range;

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::discovery::{LinearProblem, LinearRows};
use crate::math::summary::{mean, standard_deviation};

/// Smallest strength of a ridge; it keeps collinear columns solvable.
pub(crate) const MIN_RIDGE: f64 = 1e-6;

/// Normal equations of some trials.
#[derive(Clone, Debug)]
pub(crate) struct NormalEquations {
    samples: f64,
    /// Products of all columns.
    gram: DMatrix<f64>,
    /// Products of the columns with the residual.
    right: DVector<f64>,
    /// Squares of the residual, m².
    square_m2: f64,
}

impl NormalEquations {
    fn of(columns: &DMatrix<f64>, residual_m: &DVector<f64>, samples: &Range<usize>) -> Self {
        let (first, count) = (3 * samples.start, 3 * samples.len());
        let (columns, residual_m) = (columns.rows(first, count), residual_m.rows(first, count));
        NormalEquations {
            samples: samples.len() as f64,
            gram: columns.tr_mul(&columns),
            right: columns.tr_mul(&residual_m),
            square_m2: residual_m.norm_squared(),
        }
    }

    /// The equations of these trials without `others`, which are among them.
    fn without(&self, others: &NormalEquations) -> NormalEquations {
        NormalEquations {
            samples: self.samples - others.samples,
            gram: &self.gram - &others.gram,
            right: &self.right - &others.right,
            square_m2: self.square_m2 - others.square_m2,
        }
    }

    /// Squares that these amounts of the columns leave, m².
    fn left_m2(&self, amounts: &DVector<f64>) -> f64 {
        self.square_m2 - 2.0 * amounts.dot(&self.right) + amounts.dot(&(&self.gram * amounts))
    }
}

/// A regression on nuisance parameters and features.
#[derive(Clone, Debug)]
pub(crate) struct GroupedRegression {
    /// Equations of each trial, and of all together.
    trials: Vec<NormalEquations>,
    pub(crate) whole: NormalEquations,
    /// Price of the amounts of nuisance parameters: their prior precision times the noise, m².
    nuisance_price: DMatrix<f64>,
    /// Group of each feature. Features of a group are kept or dropped together.
    groups: Vec<usize>,
    group_count: usize,
    /// Root mean square length of each feature in the training trials, by which it is divided.
    scales: Vec<f64>,
}

impl GroupedRegression {
    /// The regression of `problem` on these features (three rows a sample of the training trials),
    /// each with its group, from 0.
    pub(crate) fn new(
        problem: &LinearProblem,
        features: &DMatrix<f64>,
        groups: Vec<usize>,
    ) -> GroupedRegression {
        let LinearRows { trials, residual_m, .. } = &problem.training;
        let nuisances = &problem.nuisances;
        let samples = residual_m.len() as f64 / 3.0;
        let scale = |square: f64| if square > 0.0 { (square / samples).sqrt() } else { 1.0 };
        let scales: Vec<f64> =
            features.column_iter().map(|column| scale(column.norm_squared())).collect();
        let count = nuisances.ncols();
        let mut columns = nuisances.clone().resize_horizontally(count + features.ncols(), 0.0);
        for (k, (feature, scale)) in features.column_iter().zip(&scales).enumerate() {
            columns.column_mut(count + k).copy_from(&(feature / *scale));
        }
        let all = 0..residual_m.len() / 3;
        GroupedRegression {
            trials: trials
                .iter()
                .map(|samples| NormalEquations::of(&columns, residual_m, samples))
                .collect(),
            whole: NormalEquations::of(&columns, residual_m, &all),
            nuisance_price: problem.noise_m.powi(2) * &problem.nuisance_precision,
            group_count: groups.iter().max().map_or(0, |last| last + 1),
            groups,
            scales,
        }
    }

    /// Rms length of the residual, metres.
    pub(crate) fn residual_rms_m(&self) -> f64 {
        (self.whole.square_m2 / self.whole.samples).sqrt()
    }

    /// The equations without a trial.
    pub(crate) fn without_trial(&self, trial: usize) -> NormalEquations {
        self.whole.without(&self.trials[trial])
    }

    /// Amounts of all columns, those of other groups than the `active` ones zero. The strength of
    /// the `ridge` counts features of unit rms length, once a sample.
    fn solve(&self, equations: &NormalEquations, active: &[bool], ridge: f64) -> DVector<f64> {
        let count = self.nuisance_price.ncols();
        let features = (0..self.groups.len()).filter(|&k| active[self.groups[k]]);
        let kept: Vec<usize> = (0..count).chain(features.map(|k| count + k)).collect();
        let mut normal = equations.gram.select_rows(&kept).select_columns(&kept);
        let mut block = normal.view_mut((0, 0), (count, count));
        block += &self.nuisance_price;
        (count..kept.len()).for_each(|k| normal[(k, k)] += ridge * equations.samples);
        let mut amounts = DVector::zeros(equations.right.len());
        if let Some(factor) = Cholesky::new(normal) {
            let solved = factor.solve(&equations.right.select_rows(&kept));
            kept.iter().zip(solved.iter()).for_each(|(&k, &amount)| amounts[k] = amount);
        }
        amounts
    }

    /// Nuisance parameters alone.
    pub(crate) fn null(&self, equations: &NormalEquations) -> DVector<f64> {
        self.solve(equations, &vec![false; self.group_count], MIN_RIDGE)
    }

    /// All features at once.
    pub(crate) fn full(&self, equations: &NormalEquations, ridge: f64) -> DVector<f64> {
        self.solve(equations, &vec![true; self.group_count], ridge)
    }

    /// Sequential thresholded least squares from the `full` fit with this ridge (Brunton, Proctor &
    /// Kutz, PNAS 113, 2016): groups that move the tip by less than the threshold, rms, are
    /// dropped and the others fitted again, until all that are left move it by more.
    pub(crate) fn thresholded(
        &self,
        equations: &NormalEquations,
        full: &DVector<f64>,
        Threshold { threshold_m, ridge }: Threshold,
    ) -> DVector<f64> {
        let mut amounts = full.clone();
        let mut active = vec![true; self.group_count];
        loop {
            let sizes_m = self.sizes_m(equations, &amounts);
            let kept: Vec<bool> = active
                .iter()
                .zip(sizes_m)
                .map(|(active, size_m)| *active && size_m >= threshold_m)
                .collect();
            if kept == active {
                return amounts;
            }
            active = kept;
            amounts = self.solve(equations, &active, ridge);
        }
    }

    /// Rms tip displacement by each group, metres.
    pub(crate) fn sizes_m(&self, equations: &NormalEquations, amounts: &DVector<f64>) -> Vec<f64> {
        let count = self.nuisance_price.ncols();
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); self.group_count];
        self.groups.iter().enumerate().for_each(|(k, &group)| members[group].push(count + k));
        let square_m2 = |group: &Vec<usize>| -> f64 {
            let products = group.iter().flat_map(|&a| group.iter().map(move |&b| (a, b)));
            products.map(|(a, b)| amounts[a] * equations.gram[(a, b)] * amounts[b]).sum()
        };
        members.iter().map(|group| (square_m2(group).max(0.0) / equations.samples).sqrt()).collect()
    }

    /// What the fits of `fits` leave of each trial when they have seen the others, m²: one list a
    /// fit.
    pub(crate) fn left_out_m2(
        &self,
        fits: &dyn Fn(&NormalEquations) -> Vec<DVector<f64>>,
    ) -> Vec<Vec<f64>> {
        let each: Vec<Vec<f64>> = self
            .trials
            .iter()
            .map(|trial| {
                let fitted = fits(&self.whole.without(trial));
                fitted.iter().map(|amounts| trial.left_m2(amounts)).collect()
            })
            .collect();
        let count = each.first().map_or(0, Vec::len);
        (0..count).map(|fit| each.iter().map(|squares| squares[fit]).collect()).collect()
    }

    /// Rms error, metres, where these amounts of the `features` are taken off `rows`.
    pub(crate) fn error_m(
        &self,
        rows: &LinearRows,
        features: &DMatrix<f64>,
        amounts: &DVector<f64>,
    ) -> f64 {
        let count = self.nuisance_price.ncols();
        let scaled = self.scales.iter().enumerate().map(|(k, scale)| amounts[count + k] / scale);
        let left_m =
            &rows.residual_m - features * DVector::from_iterator(self.scales.len(), scaled);
        left_m.norm() / (left_m.len() as f64 / 3.0).sqrt()
    }
}

/// Threshold of a sparse fit, and the ridge of its steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Threshold {
    pub(crate) threshold_m: f64,
    pub(crate) ridge: f64,
}

/// Whether errors trial by trial are, in the mean, within one standard error of those of a better
/// fit to the same trials (the one-standard-error rule of Breiman et al., Classification and
/// Regression Trees, 1984, section 3.4.3, of paired differences).
pub(crate) fn within_one_error(errors: &[f64], better: &[f64]) -> bool {
    let differences: Vec<f64> = errors.iter().zip(better).map(|(a, b)| a - b).collect();
    let standard_error = standard_deviation(&differences) / (differences.len() as f64).sqrt();
    standard_error.is_nan() || mean(&differences) <= standard_error
}
