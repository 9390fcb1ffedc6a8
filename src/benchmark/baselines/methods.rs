//! The methods: sparse regression, a ridge over the whole catalogue, and a Gaussian process.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::answers::BaselineAnswer;
use super::regression::{
    GroupedRegression, MIN_RIDGE, NormalEquations, Threshold, within_one_error,
};
use crate::base::Rows;
use crate::discovery::{LinearProblem, LinearRows};
use crate::learn::gp::{Gp, GpConfig};

/// Strengths of a ridge that are tried.
const RIDGES: [f64; 8] = [MIN_RIDGE, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0];
/// Strengths that a sparse fit of effects tries; more would shrink what it keeps.
const SPARSE_RIDGES: [f64; 3] = [MIN_RIDGE, 1e-4, 1e-2];
/// Thresholds that a sparse fit tries: from this share of the residual to all of it, …
const MIN_THRESHOLD: f64 = 0.01;
/// … evenly in the logarithm.
const THRESHOLDS: usize = 20;
/// Training points of the Gaussian process, as many as the paper's.
const GP_POINTS: usize = 100;

/// Columns of a regression in the training and the held-out trials.
pub(crate) struct FeatureLibrary {
    pub(crate) training: DMatrix<f64>,
    pub(crate) held_out: DMatrix<f64>,
    /// Group of each column.
    pub(crate) groups: Vec<usize>,
    /// Effect of each group; none of a library that names nothing.
    pub(crate) effects: Vec<String>,
}

impl FeatureLibrary {
    /// Responses to the effects of the catalogue, an effect (of a tendon) a group.
    pub(crate) fn catalogue(problem: &LinearProblem) -> FeatureLibrary {
        let mut effects: Vec<String> = Vec::new();
        let groups = problem.effects.iter().map(|name| {
            effects.iter().position(|effect| effect == name).unwrap_or_else(|| {
                effects.push(name.clone());
                effects.len() - 1
            })
        });
        let groups = groups.collect();
        FeatureLibrary {
            training: problem.training.responses.clone(),
            held_out: problem.held_out.responses.clone(),
            groups,
            effects,
        }
    }

    /// Polynomials of degree two, sines and cosines of commands and simulated tip, standardised,
    /// for each axis.
    pub(crate) fn polynomials(problem: &LinearProblem) -> FeatureLibrary {
        let moments = InputMoments::of(&problem.training.inputs);
        let of = |rows: &LinearRows| {
            let terms: Vec<Vec<f64>> = rows.inputs.iter().map(|row| moments.terms(row)).collect();
            let count = terms.first().map_or(0, Vec::len);
            DMatrix::from_fn(3 * terms.len(), 3 * count, |row, column| {
                let is_axis = row % 3 == column % 3;
                if is_axis { terms[row / 3][column / 3] } else { 0.0 }
            })
        };
        let training = of(&problem.training);
        FeatureLibrary {
            groups: (0..training.ncols()).collect(),
            held_out: of(&problem.held_out),
            training,
            effects: Vec::new(),
        }
    }

    /// Sparse regression: of the fits that foretell left-out trials as well as the best does, the
    /// one with the fewest groups; the best itself of a library that names nothing, if no groups
    /// do not foretell them as well.
    pub(crate) fn sparse(&self, problem: &LinearProblem) -> BaselineAnswer {
        let regression = &GroupedRegression::new(problem, &self.training, self.groups.clone());
        let names_nothing = self.effects.is_empty();
        let ridges: &[f64] = if names_nothing { &RIDGES } else { &SPARSE_RIDGES };
        let thresholds_m: Vec<f64> = (0..THRESHOLDS)
            .map(|k| MIN_THRESHOLD.powf(k as f64 / (THRESHOLDS - 1) as f64))
            .map(|share| share * regression.residual_rms_m())
            .collect();
        let fits = |equations: &NormalEquations| {
            let with = |ridge: f64| {
                let full = regression.full(equations, ridge);
                let fit = |&threshold_m: &f64| {
                    regression.thresholded(equations, &full, Threshold { threshold_m, ridge })
                };
                thresholds_m.iter().map(fit).collect::<Vec<_>>()
            };
            let sparse = ridges.iter().copied().flat_map(with);
            std::iter::once(regression.null(equations)).chain(sparse).collect()
        };
        let errors = regression.left_out_m2(&fits);
        let fitted = fits(&regression.whole);
        let groups = |fit: usize| {
            let sizes_m = regression.sizes_m(&regression.whole, &fitted[fit]);
            sizes_m.iter().filter(|size_m| **size_m > 0.0).count()
        };
        let best = least(&errors);
        let total = |fit: usize| -> f64 { errors[fit].iter().sum() };
        let chosen = (0..errors.len())
            .filter(|&fit| within_one_error(&errors[fit], &errors[best]))
            .min_by(|&a, &b| (groups(a).cmp(&groups(b))).then(total(a).total_cmp(&total(b))));
        let chosen = chosen.unwrap_or(0);
        let detects = groups(chosen) > 0;
        let chosen = if names_nothing { best } else { chosen };
        self.answer(problem, regression, &fitted[chosen], detects)
    }

    /// All groups at once with the ridge that foretells left-out trials best.
    pub(crate) fn ridge(&self, problem: &LinearProblem) -> BaselineAnswer {
        let regression = &GroupedRegression::new(problem, &self.training, self.groups.clone());
        let fits = |equations: &NormalEquations| {
            let ridges = RIDGES.iter().map(|&ridge| regression.full(equations, ridge));
            std::iter::once(regression.null(equations)).chain(ridges).collect()
        };
        let errors = regression.left_out_m2(&fits);
        let best = least(&errors);
        let detects = !within_one_error(&errors[0], &errors[best]);
        self.answer(problem, regression, &fits(&regression.whole)[best], detects)
    }

    fn answer(
        &self,
        problem: &LinearProblem,
        regression: &GroupedRegression,
        amounts: &DVector<f64>,
        detects: bool,
    ) -> BaselineAnswer {
        let none = &DVector::zeros(amounts.len());
        let amounts = if detects { amounts } else { none };
        let squares_m2 =
            regression.sizes_m(&regression.whole, amounts).into_iter().map(|size_m| size_m.powi(2));
        let squares_m2: Vec<f64> = squares_m2.collect();
        let all_m2: f64 = squares_m2.iter().sum();
        // The probability of an effect is its share of the squared displacements by all.
        let probabilities: BTreeMap<String, f64> = self
            .effects
            .iter()
            .zip(squares_m2)
            .filter(|(_, square_m2)| *square_m2 > 0.0)
            .map(|(effect, square_m2)| (effect.clone(), square_m2 / all_m2))
            .collect();
        let left_m = regression.error_m(&problem.held_out, &self.held_out, amounts);
        BaselineAnswer { detects, probabilities, left_m }
    }
}

/// The fit with the least errors.
fn least(errors: &[Vec<f64>]) -> usize {
    let total = |fit: &usize| -> f64 { errors[*fit].iter().sum() };
    (0..errors.len()).min_by(|a, b| total(a).total_cmp(&total(b))).unwrap_or(0)
}

/// Mean and standard deviation of each input.
struct InputMoments {
    moments: Vec<[f64; 2]>,
}

impl InputMoments {
    fn of(inputs: &Rows) -> InputMoments {
        let count = inputs.len().max(1) as f64;
        let moments = (0..inputs.width()).map(|k| {
            let mean = inputs.iter().map(|row| row[k]).sum::<f64>() / count;
            let square = inputs.iter().map(|row| (row[k] - mean).powi(2)).sum::<f64>() / count;
            [mean, square.sqrt()]
        });
        InputMoments { moments: moments.collect() }
    }

    /// The terms of the library at one sample. Inputs that never change have none.
    fn terms(&self, row: &[f64]) -> Vec<f64> {
        let standardised: Vec<f64> = row
            .iter()
            .zip(&self.moments)
            .filter(|(_, [_, deviation])| *deviation > 0.0)
            .map(|(value, [mean, deviation])| (value - mean) / deviation)
            .collect();
        let mut terms = vec![1.0];
        for (k, a) in standardised.iter().enumerate() {
            terms.extend([*a, a.sin(), a.cos()]);
            terms.extend(standardised[k..].iter().map(|b| a * b));
        }
        terms
    }
}

/// Whether a Gaussian process over commands and simulated tip foretells what nuisance parameters
/// leave of left-out trials.
pub(crate) fn gp_detects(problem: &LinearProblem) -> bool {
    let LinearRows { trials, residual_m, inputs, .. } = &problem.training;
    let none = DMatrix::zeros(residual_m.len(), 0);
    let regression = GroupedRegression::new(problem, &none, Vec::new());
    let mut errors = [Vec::new(), Vec::new()];
    for (number, out) in trials.iter().enumerate() {
        let amounts = regression.null(&regression.without_trial(number));
        let left_m = residual_m - &problem.nuisances * amounts;
        let row_m = |row: usize| [0, 1, 2].map(|axis| left_m[3 * row + axis]);
        let seen: Vec<usize> = (0..inputs.len()).filter(|row| !out.contains(row)).collect();
        let every = seen.len().div_ceil(GP_POINTS).max(1);
        let points: Vec<usize> = seen.into_iter().step_by(every).collect();
        let mut outputs = Rows::new(3);
        points.iter().for_each(|&row| outputs.push(&row_m(row)));
        let unseen = inputs.select(&out.clone().collect::<Vec<usize>>());
        let predicted = Gp::fit(&inputs.select(&points), &outputs, &GpConfig::default())
            .and_then(|gp| gp.mean_rows(&unseen));
        // A process that cannot be fitted foretells nothing.
        let Ok(predicted) = predicted else { return false };
        let measured = out.clone().flat_map(row_m);
        let measured: Vec<f64> = measured.collect();
        let after = measured.iter().zip(predicted.values()).map(|(m, p)| (m - p).powi(2)).sum();
        errors[0].push(measured.iter().map(|m| m * m).sum());
        errors[1].push(after);
    }
    let [before, after] = errors;
    !within_one_error(&before, &after)
}
