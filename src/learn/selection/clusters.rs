//! The paper's sparse choice (section IV-B): "we first divide 1000 by 100 to get ten points for
//! each cluster of points, then we randomly select 1 point from 10 points in each cluster".

use rand::RngExt;

use crate::base::{Rows, Seed};

/// Clusters of consecutive points of nearly equal size, with boundaries at ⌊i·total/count⌋, and one
/// point drawn from each.
pub(super) fn choose(inputs: &Rows, count: usize, seed: Seed) -> Vec<usize> {
    let mut random = seed.child("clusters").index(count as u64).rng();
    let edge = |cluster: usize| cluster * inputs.len() / count;
    (0..count).map(|cluster| random.random_range(edge(cluster)..edge(cluster + 1))).collect()
}
