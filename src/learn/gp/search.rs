//! Hyper-parameter search: many starts on few rows; the best is refined on all rows.

use super::config::GpConfig;
use super::coordinates::{SearchObjective, from_search_coordinates, to_search_coordinates};
use super::covariance::{Covariance, TrainingPoints};
use super::kernels::Hyperparameter;
use super::likelihood::Likelihood;
use super::noise_prior::NoisePenalty;
use crate::math::optimise::{Bfgs, Minimum, minimise};

/// Result of the search for one output.
pub(super) struct FittedHyperparameters {
    pub(super) theta: Vec<f64>,
    pub(super) evaluations: usize,
}

/// Growth of the number of rows from one stage of the search to the next.
const GROWTH: usize = 3;
/// Tolerance in nats while candidates compete; only the last stage uses the final tolerance.
const COARSE_TOLERANCE: f64 = 0.1;
/// Candidates kept from one stage to the next; the last stage takes one.
const MAX_CANDIDATES: usize = 3;

/// Maximises the log marginal likelihood of the standardised output `y`, plus the log density of
/// `prior`; `None` when no start is usable.
pub(super) fn search(
    config: &GpConfig,
    prior: Option<NoisePenalty>,
    covariance: &Covariance,
    points: &TrainingPoints,
    y: &[f64],
) -> Option<FittedHyperparameters> {
    let parameters = covariance.hyperparameters(config.noise_floor);
    let lengths: Vec<bool> = parameters.iter().map(|parameter| parameter.is_length).collect();
    // The likelihood costs the cube of the rows: few rows tell poor starts apart at little cost.
    let mut sizes = vec![points.n];
    let min_rows = config.start_rows.max(config.mean.least_rows(points.inputs));
    while sizes[0] > min_rows {
        sizes.insert(0, sizes[0].div_ceil(GROWTH).max(min_rows));
    }
    let mut evaluations = 0;
    // The likelihood of a kernel has several optima, as of short lengths and little noise.
    let starts = starts(config.starts, &parameters);
    let mut candidates: Vec<Vec<f64>> =
        starts.iter().map(|theta| to_search_coordinates(&lengths, theta)).collect();
    for (stage, &rows) in sizes.iter().enumerate() {
        let last = stage + 1 == sizes.len();
        let (subset, y) = evenly_spaced(points, y, rows);
        let mut likelihood =
            SearchObjective::new(Likelihood::new(covariance.clone(), config.mean, &subset, &y))
                .with_prior(prior);
        let mut climb = |start: &[f64], tolerance: f64| {
            let minimum =
                minimise(&mut likelihood, start, &limits(&parameters, &lengths, tolerance));
            evaluations += minimum.evaluations;
            minimum
        };
        let mut minima: Vec<Minimum> = if last && stage > 0 {
            // All rows are dear: only the winner of the stage before is refined on them.
            vec![climb(&candidates[0], config.tolerance)]
        } else {
            candidates.iter().map(|start| climb(start, COARSE_TOLERANCE)).collect()
        };
        minima.retain(|minimum| minimum.value.is_finite());
        minima.sort_by(|a, b| a.value.total_cmp(&b.value));
        // With one stage only the starts competed at the coarse tolerance: the winner is refined.
        if last && stage == 0 && !minima.is_empty() {
            minima = vec![climb(&minima[0].x, config.tolerance)];
        }
        candidates = distinct(minima);
    }
    candidates
        .first()
        .map(|u| FittedHyperparameters { theta: from_search_coordinates(&lengths, u), evaluations })
}

/// So many of the points, at equal distances: neighbours of a recording resemble each other.
pub(super) fn evenly_spaced(
    points: &TrainingPoints,
    y: &[f64],
    rows: usize,
) -> (TrainingPoints, Vec<f64>) {
    let which: Vec<usize> = (0..rows).map(|i| i * points.n / rows).collect();
    (points.select(&which), which.iter().map(|&i| y[i]).collect())
}

/// The best few distinct optima.
fn distinct(minima: Vec<Minimum>) -> Vec<Vec<f64>> {
    let mut out: Vec<Minimum> = Vec::new();
    for minimum in minima {
        // Equal values within the tolerance are one optimum reached twice.
        let same = |better: &Minimum| (better.value - minimum.value).abs() < 2.0 * COARSE_TOLERANCE;
        if out.len() < MAX_CANDIDATES && !out.iter().any(same) {
            out.push(minimum);
        }
    }
    out.into_iter().map(|minimum| minimum.x).collect()
}

pub(super) fn limits(parameters: &[Hyperparameter], lengths: &[bool], tolerance: f64) -> Bfgs {
    let (low, high): (Vec<f64>, Vec<f64>) = parameters
        .iter()
        .map(|parameter| (parameter.bounds.0.ln(), parameter.bounds.1.ln()))
        .unzip();
    let bounds = to_search_coordinates(lengths, &low)
        .into_iter()
        .zip(to_search_coordinates(lengths, &high))
        .collect();
    // A step of 2 in a logarithm is a factor of seven.
    Bfgs { bounds, tolerance, max_evaluations: 300, max_step: 2.0 }
}

/// The conventional start, then a low-discrepancy sequence in the plausible box: the additive
/// recurrence with powers of the root of `x^(d+1) = x + 1`, which needs no seed.
fn starts(count: usize, parameters: &[Hyperparameter]) -> Vec<Vec<f64>> {
    let mut out: Vec<Vec<f64>> =
        vec![parameters.iter().map(|parameter| parameter.start.ln()).collect()];
    // Fixed-point iteration for the generalised golden ratio.
    let root =
        (0..64).fold(2.0_f64, |root, _| (1.0 + root).powf(1.0 / (parameters.len() as f64 + 1.0)));
    for i in 1..count {
        let coordinate = |(k, parameter): (usize, &Hyperparameter)| {
            let (low, high) = parameter.plausible;
            let share = (0.5 + i as f64 * root.powi(-(k as i32) - 1)).fract();
            low.ln() + share * (high.ln() - low.ln())
        };
        out.push(parameters.iter().enumerate().map(coordinate).collect());
    }
    out
}
