//! Farthest-point traversal: Gonzalez 1985, within a factor of two of the smallest possible gap.

use super::{largest, squared_distance};
use crate::base::{Rows, Seed};

/// Begins with the point nearest to the mean.
pub(super) fn choose(inputs: &Rows, count: usize, _seed: Seed) -> Vec<usize> {
    // The inputs are standardised, so that their mean is zero.
    let central: Vec<f64> =
        inputs.iter().map(|row| -row.iter().map(|x| x * x).sum::<f64>()).collect();
    let mut chosen = vec![largest(&central)];
    let mut nearest = vec![f64::INFINITY; inputs.len()];
    while chosen.len() < count {
        let last = chosen[chosen.len() - 1];
        for (distance, row) in nearest.iter_mut().zip(inputs.iter()) {
            *distance = distance.min(squared_distance(row, inputs.row(last)));
        }
        // A chosen point stays behind points that coincide with one.
        nearest[last] = -1.0;
        chosen.push(largest(&nearest));
    }
    chosen
}
