//! Hyper-parameters at an end of the range of their search: the data alone would have gone on.

use super::Gp;

/// A hyper-parameter within this factor of an end is at it: where the likelihood hardly slopes, a
/// search ends before it has reached the end.
const END_FACTOR: f64 = 2.0;
/// Noise is at its least, too, where the posterior density there is less by no more than this,
/// nats: the data do not tell it from none.
const UNTOLD_NATS: f64 = 0.1;
/// Larger noise variances, standardised, are not compared with the least.
const SMALL_NOISE_VARIANCE: f64 = 1e-2;

/// A hyper-parameter at an end of its range.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RangeEnd {
    /// Output, from 0.
    pub output: usize,
    /// Name of the hyper-parameter.
    pub name: String,
    /// The upper end: of a length-scale that of an input without influence. Else the lower one: of
    /// the noise variance the square of `noise_floor`.
    pub is_upper: bool,
}

impl RangeEnd {
    /// `noise variance low`.
    pub fn describe(&self) -> String {
        format!("{} {}", self.name, if self.is_upper { "high" } else { "low" })
    }
}

impl Gp {
    /// For each output, whether the noise is as good as at its least.
    fn noise_is_untold(&self) -> Vec<bool> {
        let least = 2.0 * self.config.noise_floor.ln();
        let noise = |theta: &Vec<f64>| theta.last().copied().unwrap_or(0.0);
        let is_small = |theta: &Vec<f64>| noise(theta) < SMALL_NOISE_VARIANCE.ln();
        let none = vec![false; self.theta.len()];
        if !self.theta.iter().any(is_small) {
            return none;
        }
        let mut floored = self.theta.clone();
        floored.iter_mut().filter_map(|theta| theta.last_mut()).for_each(|noise| *noise = least);
        let Ok(floored) = Gp::condition(&self.inputs, &self.outputs, &self.config, floored, 0)
        else {
            return none;
        };
        let (here, there) = (self.log_marginal_likelihood(), floored.log_marginal_likelihood());
        let is_untold = |(output, theta): (usize, &Vec<f64>)| {
            let scale = self.output_standardiser.scale(output);
            let prior = self.config.noise_prior.and_then(|prior| prior.standardised(scale));
            let penalty = |at: f64| prior.map_or(0.0, |prior| prior.value(at));
            let loss = here[output] - there[output] + penalty(least) - penalty(noise(theta));
            is_small(theta) && loss < UNTOLD_NATS
        };
        self.theta.iter().enumerate().map(is_untold).collect()
    }

    /// The hyper-parameters at an end of their range, output by output.
    pub fn range_ends(&self) -> Vec<RangeEnd> {
        let parameters = self.covariance.hyperparameters(self.config.noise_floor);
        let untold = self.noise_is_untold();
        let mut found = Vec::new();
        for (output, theta) in self.theta.iter().enumerate() {
            for (k, (parameter, ln_value)) in parameters.iter().zip(theta).enumerate() {
                // The noise variance is the last.
                let is_untold = k + 1 == parameters.len() && untold[output];
                let (low, high) = parameter.bounds;
                let is_upper = *ln_value >= (high / END_FACTOR).ln();
                if is_upper || is_untold || *ln_value <= (low * END_FACTOR).ln() {
                    found.push(RangeEnd { output, name: parameter.name.clone(), is_upper });
                }
            }
        }
        found
    }
}
