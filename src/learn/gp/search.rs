//! The search for hyper-parameters: many starts on a few rows, the winner carried to all rows.

use super::config::GpConfig;
use super::covariance::{Layout, Points};
use super::kernels::Kernel;
use super::likelihood::Likelihood;
use crate::learn::optimise::{Bfgs, Minimum, minimise};

/// What a search found for one output.
pub(super) struct Found {
    pub(super) theta: Vec<f64>,
    pub(super) evaluations: usize,
}

/// Rows grow by this factor from one stage of the search to the next.
const GROWTH: usize = 3;
/// Nats by which the starts are told apart; only the winner is finished.
const COARSE: f64 = 0.1;

/// Maximises the log marginal likelihood of the standardised output `y`; `None` when no start is usable.
pub(super) fn search(config: &GpConfig, points: &Points, y: &[f64]) -> Option<Found> {
    let kernel = config.kernel.0;
    let mut sizes = vec![points.n];
    while sizes[0] > config.start_rows {
        sizes.insert(0, sizes[0].div_ceil(GROWTH).max(config.start_rows));
    }
    let mut evaluations = 0;
    let mut best: Option<Minimum> = None;
    for (stage, &rows) in sizes.iter().enumerate() {
        let which: Vec<usize> = (0..rows).map(|i| i * points.n / rows).collect();
        let (few, y): (Points, Vec<f64>) = (points.select(&which), which.iter().map(|&i| y[i]).collect());
        let mut likelihood = Likelihood::new(kernel, &few, &y);
        let limits = |tolerance| limits(config, kernel, points.inputs, tolerance);
        if stage == 0 {
            for start in starts(config, kernel, points.inputs) {
                let found = minimise(&mut likelihood, &start, None, &limits(COARSE));
                evaluations += found.evaluations;
                if found.value.is_finite() && best.as_ref().is_none_or(|best| found.value < best.value) {
                    best = Some(found);
                }
            }
        }
        let Minimum { x, mut hessian, .. } = best?;
        if stage > 0 {
            let growth = rows as f64 / sizes[stage - 1] as f64;
            hessian.iter_mut().for_each(|h| *h *= growth);
        }
        let last = stage + 1 == sizes.len();
        let found = minimise(&mut likelihood, &x, Some(hessian), &limits(if last { config.tolerance } else { COARSE }));
        evaluations += found.evaluations;
        best = found.value.is_finite().then_some(found);
    }
    best.map(|best| Found { theta: best.x, evaluations })
}

fn limits(config: &GpConfig, kernel: &dyn Kernel, inputs: usize, tolerance: f64) -> Bfgs {
    let layout = Layout::of(kernel, inputs);
    let mut bounds = vec![(1e-3, 1e3)];
    bounds.extend(vec![(1e-2, 1e3); layout.lengths]);
    bounds.extend(kernel.shapes().iter().map(|shape| shape.bounds));
    bounds.push((config.noise_floor * config.noise_floor, 10.0));
    let bounds = bounds.into_iter().map(|(low, high): (f64, f64)| (low.ln(), high.ln())).collect();
    Bfgs { bounds, tolerance, max_evaluations: 300, max_step: 2.0 }
}

/// The conventional start, then points that fill the plausible box evenly: the additive recurrence whose steps are
/// powers of the root of `x^(d+1) = x + 1`, which needs no seed.
fn starts(config: &GpConfig, kernel: &dyn Kernel, inputs: usize) -> Vec<Vec<f64>> {
    let layout = Layout::of(kernel, inputs);
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
