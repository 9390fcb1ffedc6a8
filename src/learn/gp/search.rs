//! Hyper-parameter search: many starts on few rows; the best is refined on all rows.

use super::config::GpConfig;
use super::coordinates::{SearchObjective, from_search_coordinates, to_search_coordinates};
use super::covariance::{HyperparameterLayout, TrainingPoints};
use super::kernels::Kernel;
use super::likelihood::Likelihood;
use crate::math::optimise::{Bfgs, Minimum, minimise};

/// Result of the search for one output.
pub(super) struct FittedHyperparameters {
    pub(super) theta: Vec<f64>,
    pub(super) evaluations: usize,
}

/// Growth of the number of rows from one stage of the search to the next.
const GROWTH: usize = 3;
/// Tolerance in nats while candidates compete; only the last stage uses the final tolerance.
const COARSE: f64 = 0.1;
/// Candidates kept from one stage to the next; the last stage takes one.
const KEPT: usize = 3;
/// Maximises the log marginal likelihood of the standardised output `y`; `None` when no start is usable.
pub(super) fn search(config: &GpConfig, points: &TrainingPoints, y: &[f64]) -> Option<FittedHyperparameters> {
    let kernel = config.kernel.0;
    let layout = HyperparameterLayout::of(kernel, points.inputs);
    let mut sizes = vec![points.n];
    while sizes[0] > config.start_rows {
        sizes.insert(0, sizes[0].div_ceil(GROWTH).max(config.start_rows));
    }
    let mut evaluations = 0;
    let starts = starts(config, kernel, points.inputs);
    let mut candidates: Vec<Vec<f64>> = starts.iter().map(|theta| to_search_coordinates(layout, theta)).collect();
    for (stage, &rows) in sizes.iter().enumerate() {
        let last = stage + 1 == sizes.len();
        let which: Vec<usize> = (0..rows).map(|i| i * points.n / rows).collect();
        let (few, y): (TrainingPoints, Vec<f64>) = (points.select(&which), which.iter().map(|&i| y[i]).collect());
        let mut likelihood = SearchObjective::new(Likelihood::new(kernel, &few, &y));
        let mut climb = |start: &[f64], tolerance: f64| {
            let found = minimise(&mut likelihood, start, &limits(config, kernel, points.inputs, tolerance));
            evaluations += found.evaluations;

            found
        };
        let mut found: Vec<Minimum> = if last && stage > 0 {
            vec![climb(&candidates[0], config.tolerance)]
        } else {
            candidates.iter().map(|start| climb(start, COARSE)).collect()
        };
        found.retain(|minimum| minimum.value.is_finite());
        found.sort_by(|a, b| a.value.total_cmp(&b.value));
        if last && stage == 0 && !found.is_empty() {
            found = vec![climb(&found[0].x, config.tolerance)];
        }
        candidates = distinct(found);
    }
    candidates.first().map(|u| FittedHyperparameters { theta: from_search_coordinates(layout, u), evaluations })
}

/// The best few distinct optima.
fn distinct(found: Vec<Minimum>) -> Vec<Vec<f64>> {
    let mut out: Vec<Minimum> = Vec::new();
    for minimum in found {
        let same = |kept: &Minimum| (kept.value - minimum.value).abs() < 2.0 * COARSE;
        if out.len() < KEPT && !out.iter().any(same) {
            out.push(minimum);
        }
    }
    out.into_iter().map(|minimum| minimum.x).collect()
}

fn limits(config: &GpConfig, kernel: &dyn Kernel, inputs: usize, tolerance: f64) -> Bfgs {
    let layout = HyperparameterLayout::of(kernel, inputs);
    let mut bounds = vec![(1e-3, 1e3)];
    bounds.extend(vec![(1e-2, 1e3); layout.lengths]);
    bounds.extend(kernel.shapes().iter().map(|shape| shape.bounds));
    bounds.push((config.noise_floor * config.noise_floor, 10.0));
    let (low, high): (Vec<f64>, Vec<f64>) =
        bounds.into_iter().map(|(low, high): (f64, f64)| (low.ln(), high.ln())).unzip();
    let bounds = to_search_coordinates(layout, &low).into_iter().zip(to_search_coordinates(layout, &high)).collect();
    Bfgs { bounds, tolerance, max_evaluations: 300, max_step: 2.0 }
}

/// The conventional start, then a low-discrepancy sequence in the plausible box: the additive recurrence with powers of
/// the root of `x^(d+1) = x + 1`, which needs no seed.
fn starts(config: &GpConfig, kernel: &dyn Kernel, inputs: usize) -> Vec<Vec<f64>> {
    let layout = HyperparameterLayout::of(kernel, inputs);
    let mut box_ = vec![(0.3, 10.0)];
    box_.extend(vec![(0.3, 30.0); layout.lengths]);
    box_.extend(kernel.shapes().iter().map(|shape| (shape.start / 4.0, shape.start * 4.0)));
    box_.push((1e-4_f64, 0.3_f64));
    let mut conventional = vec![0.0; layout.len()];
    for (k, shape) in kernel.shapes().iter().enumerate() {
        conventional[1 + layout.lengths + k] = shape.start.ln();
    }
    conventional[layout.len() - 1] = 0.1_f64.ln();
    let mut out = vec![conventional];
    let root = (0..64).fold(2.0_f64, |root, _| (1.0 + root).powf(1.0 / (layout.len() as f64 + 1.0)));
    for i in 1..config.starts {
        let coordinate = |(k, &(low, high)): (usize, &(f64, f64))| {
            let share = (0.5 + i as f64 * root.powi(-(k as i32) - 1)).fract();
            low.ln() + share * (high.ln() - low.ln())
        };
        out.push(box_.iter().enumerate().map(coordinate).collect());
    }
    out
}
