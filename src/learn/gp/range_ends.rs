//! Hyper-parameters at an end of the range of their search: the data, alone, would have gone on.

use super::Gp;
use super::coordinates::to_search_coordinates;

/// Distance from an end, in the search's coordinates, within which a hyper-parameter is at it. A
/// step of the search that would leave the box ends on its border.
const END_TOLERANCE: f64 = 1e-6;

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

    /// Whether it is the noise at its least, which makes intervals too narrow.
    pub fn is_least_noise(&self) -> bool {
        self.name == "noise variance" && !self.is_upper
    }
}

impl Gp {
    /// The hyper-parameters at an end of their range, output by output.
    pub fn range_ends(&self) -> Vec<RangeEnd> {
        let parameters = self.covariance.hyperparameters(self.config.noise_floor);
        let lengths: Vec<bool> = parameters.iter().map(|parameter| parameter.is_length).collect();
        let coordinates = |theta: &[f64]| to_search_coordinates(&lengths, theta);
        let ends = |end: fn(&(f64, f64)) -> f64| -> Vec<f64> {
            let theta: Vec<f64> = parameters.iter().map(|one| end(&one.bounds).ln()).collect();
            coordinates(&theta)
        };
        let (low, high) = (ends(|bounds| bounds.0), ends(|bounds| bounds.1));
        let mut found = Vec::new();
        for (output, theta) in self.theta.iter().enumerate() {
            for (k, u) in coordinates(theta).into_iter().enumerate() {
                let is_upper = u > high[k] - END_TOLERANCE;
                if is_upper || u < low[k] + END_TOLERANCE {
                    found.push(RangeEnd { output, name: parameters[k].name.clone(), is_upper });
                }
            }
        }
        found
    }
}
