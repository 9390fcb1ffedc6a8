//! Coordinates of the hyper-parameter search.
//!
//! Along `ln l` the likelihood of an input that does not matter slopes ever less and the search
//! crawls; along `λ = l⁻²` it is nearly linear there. So the search moves in `u = −½ ln(λ + ε)`:
//! `ln l` for short length-scales, linear in λ for long ones, and the end of the range (an input
//! without influence) is an ordinary bound.

use super::covariance::Covariance;
use super::likelihood::Likelihood;
use super::noise_prior::NoisePenalty;
use crate::math::optimise::Objective;

/// ε: the bend lies at the standardised length-scale 10.
const BEND: f64 = 0.01;
/// Curvature in nats per squared coordinate that every hyper-parameter has at least: keeps the step
/// finite along those that the data say nothing of.
const RIDGE: f64 = 0.3;

/// The search's coordinates from logarithmic hyper-parameters; `lengths` says which of them are
/// length-scales.
pub(super) fn to_search_coordinates(lengths: &[bool], theta: &[f64]) -> Vec<f64> {
    map_lengths(lengths, theta, |ln_length| -0.5 * ((-2.0 * ln_length).exp() + BEND).ln())
}

/// Logarithmic hyper-parameters from the search's coordinates.
pub(super) fn from_search_coordinates(lengths: &[bool], u: &[f64]) -> Vec<f64> {
    map_lengths(lengths, u, |u| -0.5 * ((-2.0 * u).exp() - BEND).ln())
}

fn map_lengths(lengths: &[bool], values: &[f64], map: impl Fn(f64) -> f64) -> Vec<f64> {
    values.iter().zip(lengths).map(|(&v, &is_length)| if is_length { map(v) } else { v }).collect()
}

/// Minus a log likelihood as a function of the logarithmic hyper-parameters of a covariance.
pub(super) trait LogLikelihood: Objective {
    /// The covariance.
    fn covariance(&self) -> &Covariance;
    /// Estimated Fisher information at the latest value, row-major, where there is one.
    fn information(&mut self) -> Option<Vec<f64>>;
}

impl LogLikelihood for Likelihood<'_> {
    fn covariance(&self) -> &Covariance {
        &self.covariance
    }

    fn information(&mut self) -> Option<Vec<f64>> {
        Some(self.information())
    }
}

/// A likelihood, times the prior of the noise where there is one, as a function of the search's
/// coordinates.
pub(super) struct SearchObjective<L> {
    likelihood: L,
    prior: Option<NoisePenalty>,
    /// `ln σ_n²` at the latest value: the last coordinate, which is no length-scale.
    log_noise_variance: f64,
    /// Which hyper-parameters are length-scales.
    lengths: Vec<bool>,
    /// `dθ/du` of each hyper-parameter at the latest value.
    stretch: Vec<f64>,
}

impl<L: LogLikelihood> SearchObjective<L> {
    pub(super) fn new(likelihood: L) -> Self {
        let lengths = likelihood
            .covariance()
            .hyperparameters(1.0)
            .iter()
            .map(|parameter| parameter.is_length)
            .collect();
        SearchObjective {
            lengths,
            likelihood,
            prior: None,
            log_noise_variance: f64::NAN,
            stretch: Vec::new(),
        }
    }

    /// With a prior for the noise.
    pub(super) fn with_prior(self, prior: Option<NoisePenalty>) -> Self {
        SearchObjective { prior, ..self }
    }
}

impl<L: LogLikelihood> Objective for SearchObjective<L> {
    fn value(&mut self, u: &[f64]) -> f64 {
        let theta = from_search_coordinates(&self.lengths, u);
        // With λ = l⁻² the definition of u gives d ln l/du = 1 + ε/λ.
        let stretch = |(ln, is_length): (&f64, &bool)| {
            if *is_length { 1.0 + BEND * (2.0 * ln).exp() } else { 1.0 }
        };
        // Kept for the gradient, which is always asked at the latest value.
        self.stretch = theta.iter().zip(&self.lengths).map(stretch).collect();
        self.log_noise_variance = theta.last().copied().unwrap_or(f64::NAN);
        let value = self.likelihood.value(&theta);
        self.prior.map_or(value, |prior| value + prior.value(self.log_noise_variance))
    }

    fn gradient(&mut self, out: &mut [f64]) {
        self.likelihood.gradient(out);
        out.iter_mut().zip(&self.stretch).for_each(|(g, stretch)| *g *= stretch);
        if let (Some(prior), Some(last)) = (self.prior, out.last_mut()) {
            *last += prior.slope(self.log_noise_variance);
        }
    }

    fn curvature(&mut self) -> Option<Vec<f64>> {
        let mut information = self.likelihood.information()?;
        let n = self.stretch.len();
        for (place, value) in information.iter_mut().enumerate() {
            let (i, j) = (place / n, place % n);
            *value = *value * self.stretch[i] * self.stretch[j] + if i == j { RIDGE } else { 0.0 };
        }
        if let (Some(prior), Some(last)) = (self.prior, information.last_mut()) {
            *last += prior.curvature(self.log_noise_variance);
        }
        Some(information)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_come_back_and_agree_where_lengths_are_short() {
        let lengths = [false, true, true, true, false, false];
        let theta = [0.3, -2.0, 1.0, 1000.0_f64.ln(), 0.7, -3.0];
        let u = to_search_coordinates(&lengths, &theta);
        from_search_coordinates(&lengths, &u)
            .iter()
            .zip(theta)
            .for_each(|(a, b)| assert!((a - b).abs() < 1e-9, "{a} {b}"));
        assert!((u[1] + 2.0).abs() < 1e-3 && u[3] < 2.4);
        assert_eq!((u[0], u[4], u[5]), (0.3, 0.7, -3.0));
    }
}
