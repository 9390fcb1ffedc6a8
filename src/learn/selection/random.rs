//! Points drawn evenly without replacement: the first steps of a Fisher–Yates shuffle.

use rand::RngExt;

use crate::base::{Rows, Seed};

pub(super) fn choose(inputs: &Rows, count: usize, seed: Seed) -> Vec<usize> {
    let mut random = seed.child("random points").index(count as u64).rng();
    let mut all: Vec<usize> = (0..inputs.len()).collect();
    for place in 0..count {
        all.swap(place, random.random_range(place..inputs.len()));
    }
    all.truncate(count);
    all
}
