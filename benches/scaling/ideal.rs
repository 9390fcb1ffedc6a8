//! The best that any scheduler could do: stages alone, nothing else costs anything.

use crate::cluster::Costs;
use spinebench::runner::Graph;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

impl Costs {
    /// Time of all stages, s.
    pub fn all_s(&self) -> f64 {
        self.stage_s.iter().sum()
    }

    /// Each result is written once and read by everyone who asks for it.
    pub fn all_bytes(&self, graph: &Graph) -> f64 {
        let read =
            |stage: usize| graph.inputs(stage).iter().map(|&input| self.bytes[input]).sum::<f64>();
        (0..graph.len()).map(|stage| self.bytes[stage] + read(stage)).sum()
    }

    /// Length of the longest chain, s.
    pub fn chain_s(&self, graph: &Graph) -> f64 {
        let mut ends = vec![0.0_f64; graph.len()];
        for stage in 0..graph.len() {
            let before = graph.inputs(stage).iter().map(|&input| ends[input]).fold(0.0, f64::max);
            ends[stage] = before + self.stage_s[stage];
        }
        ends.into_iter().fold(0.0, f64::max)
    }

    /// Every stage as soon as its inputs are there and a node is free, the longest chain behind it
    /// first (Graham's list scheduling); nothing costs anything but the stages.
    pub fn ideal_s(&self, graph: &Graph, nodes: usize) -> f64 {
        let count = graph.len();
        let (mut rank, mut waits, mut next) =
            (vec![0.0_f64; count], vec![0; count], vec![Vec::new(); count]);
        for stage in (0..count).rev() {
            rank[stage] += self.stage_s[stage];
            waits[stage] = graph.inputs(stage).len();
            for &input in graph.inputs(stage) {
                next[input].push(stage);
                rank[input] = rank[input].max(rank[stage]);
            }
        }
        let order = |stage: usize| ((rank[stage] * 1e6) as u64, Reverse(stage));
        let mut ready: BinaryHeap<_> =
            (0..count).filter(|&stage| waits[stage] == 0).map(order).collect();
        let mut running: BinaryHeap<Reverse<(u64, usize)>> = BinaryHeap::new();
        let (mut now_us, mut free) = (0, nodes);
        loop {
            while free > 0
                && let Some((_, Reverse(stage))) = ready.pop()
            {
                running.push(Reverse((now_us + (self.stage_s[stage] * 1e6) as u64, stage)));
                free -= 1;
            }
            let Some(Reverse((end_us, stage))) = running.pop() else { return now_us as f64 * 1e-6 };
            (now_us, free) = (end_us, free + 1);
            for &follower in &next[stage] {
                waits[follower] -= 1;
                if waits[follower] == 0 {
                    ready.push(order(follower));
                }
            }
        }
    }
}
