//! The points nearest to the centres of k-means: Lloyd 1982 from the starts of k-means++, Arthur &
//! Vassilvitskii 2007.

use rand::RngExt;

use super::squared_distance;
use crate::base::{Generator, Rows, Seed};

/// Iterations of Lloyd's algorithm at most.
const MAX_ITERATIONS: usize = 50;

pub(super) fn choose(inputs: &Rows, count: usize, seed: Seed) -> Vec<usize> {
    let mut random = seed.child("k-means").index(count as u64).rng();
    let mut centres = starts(inputs, count, &mut random);
    let mut owners = vec![usize::MAX; inputs.len()];
    for _ in 0..MAX_ITERATIONS {
        let nearest: Vec<usize> = inputs.iter().map(|row| nearest_centre(row, &centres)).collect();
        if nearest == owners {
            break;
        }
        owners = nearest;
        for (k, centre) in centres.iter_mut().enumerate() {
            let members: Vec<&[f64]> = inputs
                .iter()
                .zip(&owners)
                .filter(|(_, owner)| **owner == k)
                .map(|(row, _)| row)
                .collect();
            // A centre that has lost its points stays where it was.
            if !members.is_empty() {
                let mean =
                    |d: usize| members.iter().map(|row| row[d]).sum::<f64>() / members.len() as f64;
                *centre = (0..inputs.width()).map(mean).collect();
            }
        }
    }
    let mut chosen: Vec<usize> = Vec::with_capacity(count);
    for centre in &centres {
        // Two centres may share their nearest point; each needs one of its own.
        let free = (0..inputs.len()).filter(|i| !chosen.contains(i));
        let to = |i: &usize| squared_distance(inputs.row(*i), centre);
        chosen.extend(free.min_by(|a, b| to(a).total_cmp(&to(b))));
    }
    chosen
}

fn nearest_centre(row: &[f64], centres: &[Vec<f64>]) -> usize {
    let to = |k: &usize| squared_distance(row, &centres[*k]);
    (0..centres.len()).min_by(|a, b| to(a).total_cmp(&to(b))).unwrap_or(0)
}

/// Points drawn one by one with a probability in proportion to their squared distance from those
/// drawn before.
fn starts(inputs: &Rows, count: usize, random: &mut Generator) -> Vec<Vec<f64>> {
    let mut centres = vec![inputs.row(random.random_range(0..inputs.len())).to_vec()];
    let mut nearest = vec![f64::INFINITY; inputs.len()];
    while centres.len() < count {
        let last = &centres[centres.len() - 1];
        for (distance, row) in nearest.iter_mut().zip(inputs.iter()) {
            *distance = distance.min(squared_distance(row, last));
        }
        let mut remaining = random.random_range(0.0..1.0) * nearest.iter().sum::<f64>();
        let passed = |distance: &f64| {
            remaining -= distance;
            remaining <= 0.0
        };
        let drawn = nearest.iter().position(passed).unwrap_or(inputs.len() - 1);
        centres.push(inputs.row(drawn).to_vec());
    }
    centres
}
