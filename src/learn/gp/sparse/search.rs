//! The search for the hyper-parameters of a sparse process.

use super::SparseLikelihood;
use crate::learn::gp::config::GpConfig;
use crate::learn::gp::coordinates::{
    SearchObjective, from_search_coordinates, to_search_coordinates,
};
use crate::learn::gp::covariance::{Covariance, TrainingPoints};
use crate::learn::gp::likelihood::Likelihood;
use crate::learn::gp::noise_prior::NoisePenalty;
use crate::learn::gp::search::{self, FittedHyperparameters};
use crate::learn::gp::sparse::greedy_conditional_variance;
use crate::math::optimise::{Objective, minimise};

/// Rows, evenly spaced, of the exact process from whose hyper-parameters the search starts.
const START_ROWS: usize = 500;
/// Times that inducing points are chosen, each time under the hyper-parameters found with those
/// before.
const ROUNDS: usize = 2;
/// Expected improvement in nats below which the search ends: small beside the several thousand of
/// such a likelihood.
const TOLERANCE: f64 = 0.01;

/// Maximises the likelihood (FITC) or its bound (SGPR) of the standardised output `y`, with the
/// density of `prior`; `None` when no start is usable.
pub(crate) fn search(
    config: &GpConfig,
    prior: Option<NoisePenalty>,
    covariance: &Covariance,
    points: &TrainingPoints,
    y: &[f64],
) -> Option<FittedHyperparameters> {
    let rows = points.n.min(START_ROWS);
    let (subset, subset_y) = search::evenly_spaced(points, y, rows);
    let FittedHyperparameters { mut theta, mut evaluations } =
        search::search(config, prior, covariance, &subset, &subset_y)?;
    let parameters = covariance.hyperparameters(config.noise_floor);
    let lengths: Vec<bool> = parameters.iter().map(|parameter| parameter.is_length).collect();
    let limits = search::limits(&parameters, &lengths, config.tolerance.max(TOLERANCE));
    for _ in 0..ROUNDS {
        // Fixed during a climb: else the likelihood would jump where a choice changes.
        let inducing =
            greedy_conditional_variance(covariance, &theta, points, config.inducing_points);
        let mut start = Likelihood::new(covariance.clone(), config.mean, &subset, &subset_y);
        start.value(&theta);
        let likelihood = SparseLikelihood::new(
            config.approximation,
            config.mean,
            covariance.clone(),
            points,
            y,
            &inducing,
        )
        .with_information(start.information(), points.n as f64 / rows as f64);
        let minimum = minimise(
            &mut SearchObjective::new(likelihood).with_prior(prior),
            &to_search_coordinates(&lengths, &theta),
            &limits,
        );
        evaluations += minimum.evaluations;
        if !minimum.value.is_finite() {
            return None;
        }
        theta = from_search_coordinates(&lengths, &minimum.x);
    }
    Some(FittedHyperparameters { theta, evaluations })
}

impl SparseLikelihood<'_> {
    /// With the Fisher information of an exact process on one sample in `share`, as a first
    /// estimate of the curvature.
    fn with_information(mut self, mut information: Vec<f64>, share: f64) -> Self {
        information.iter_mut().for_each(|value| *value *= share);
        self.information = information;
        self
    }
}
