//! A cluster on paper: recorded stage times on the graph of a campaign, carried out as the Slurm executor would.

use crate::recorded::Recorded;
use spinebench::data::rows::ScalingRow;
use spinebench::runner::slurm::waves;
use spinebench::runner::{Campaign, Graph, Need};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// What is assumed of the cluster.
pub struct Assumed {
    /// From the moment that a node is free to the first stage: launch, start of the program, expansion of the specs, s.
    pub begin_s: f64,
    /// Tasks that the scheduler launches in a second.
    pub launches_per_s: f64,
    /// What the shared store delivers to all nodes together, bytes a second.
    pub store_bytes_s: f64,
    /// Time to open or to file one entry, s.
    pub store_latency_s: f64,
    /// Length of a task that short stages are put together to, ms.
    pub task_ms: u64,
}

impl Default for Assumed {
    /// A scheduler as measured on the emulated one of `tests/program/slurm.rs`, a store behind one 10-gigabit line.
    fn default() -> Self {
        Assumed { begin_s: 1.0, launches_per_s: 50.0, store_bytes_s: 1.0e9, store_latency_s: 0.005, task_ms: 60_000 }
    }
}

/// The campaign on `nodes` nodes of one processor each: without and with a cluster's costs.
pub fn replay(campaign: &Campaign, recorded: &Recorded, assumed: &Assumed, nodes: usize) -> [ScalingRow; 2] {
    let graph = &campaign.graph;
    let work = Work::new(graph, recorded);
    let ideal_s = work.ideal_s(graph, nodes);
    let arrays = work.arrays(graph, assumed, nodes);
    let all_s: f64 = work.stage_s.iter().sum();
    let row = |system: &str, wall_s: f64, bytes: f64, bound: &str| ScalingRow {
        system: system.to_owned(),
        workers: nodes as u64,
        stages: graph.len() as u64,
        wall_s,
        efficiency: all_s / (nodes as f64 * wall_s),
        store_gb: bytes / 1e9,
        store_mb_s: bytes / 1e6 / wall_s,
        bound: bound.to_owned(),
    };
    let chain_s = work.chain_s(graph);
    let bound = if chain_s > 0.9 * ideal_s { "longest chain" } else { "work" };
    [
        row("ideal cluster", ideal_s, work.bytes(graph), bound),
        row("job arrays", arrays.wall_s, arrays.bytes, arrays.bound),
    ]
}

/// What each stage takes and how large its result is.
struct Work {
    stage_s: Vec<f64>,
    bytes: Vec<f64>,
}

/// A campaign carried out as job arrays.
struct Arrays {
    wall_s: f64,
    bytes: f64,
    bound: &'static str,
}

impl Work {
    fn new(graph: &Graph, recorded: &Recorded) -> Work {
        let kind = |stage: usize| graph.describe(stage).0;
        Work {
            stage_s: (0..graph.len()).map(|stage| recorded.wall_s(kind(stage), stage)).collect(),
            bytes: (0..graph.len()).map(|stage| recorded.bytes(kind(stage))).collect(),
        }
    }

    /// Each result is written once and read by everyone who asks for it.
    fn bytes(&self, graph: &Graph) -> f64 {
        let read = |stage: usize| graph.inputs(stage).iter().map(|&input| self.bytes[input]).sum::<f64>();
        (0..graph.len()).map(|stage| self.bytes[stage] + read(stage)).sum()
    }

    /// Length of the longest chain, s.
    fn chain_s(&self, graph: &Graph) -> f64 {
        let mut ends = vec![0.0_f64; graph.len()];
        for stage in 0..graph.len() {
            let before = graph.inputs(stage).iter().map(|&input| ends[input]).fold(0.0, f64::max);
            ends[stage] = before + self.stage_s[stage];
        }
        ends.into_iter().fold(0.0, f64::max)
    }

    /// Every stage as soon as its inputs are there and a node is free, the longest chain behind it first (Graham's list
    /// scheduling); nothing costs anything but the stages.
    fn ideal_s(&self, graph: &Graph, nodes: usize) -> f64 {
        let count = graph.len();
        let (mut rank, mut waits, mut next) = (vec![0.0_f64; count], vec![0; count], vec![Vec::new(); count]);
        for stage in (0..count).rev() {
            rank[stage] += self.stage_s[stage];
            waits[stage] = graph.inputs(stage).len();
            for &input in graph.inputs(stage) {
                next[input].push(stage);
                rank[input] = rank[input].max(rank[stage]);
            }
        }
        let order = |stage: usize| ((rank[stage] * 1e6) as u64, Reverse(stage));
        let mut ready: BinaryHeap<_> = (0..count).filter(|&stage| waits[stage] == 0).map(order).collect();
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

    /// Waves of tasks, each wave after the last task of the one before; tasks in their order, each on the first free node.
    fn arrays(&self, graph: &Graph, assumed: &Assumed, nodes: usize) -> Arrays {
        let waves = waves(graph, &vec![Need::Compute; graph.len()], assumed.task_ms);
        let mut done = vec![false; graph.len()];
        let (mut now_s, mut bytes, mut tasks, mut waited_s) = (0.0_f64, 0.0, 0, 0.0);
        for wave in &waves {
            let before = done.clone();
            let mut free: BinaryHeap<Reverse<u64>> = (0..nodes).map(|_| Reverse(0)).collect();
            let (mut wave_s, mut wave_bytes, mut busy_s) = (0.0_f64, 0.0, 0.0);
            for (number, task) in wave.iter().enumerate() {
                let Reverse(free_us) = free.pop().unwrap_or(Reverse(0));
                let launched_s = (free_us as f64 * 1e-6).max(number as f64 / assumed.launches_per_s);
                let (task_s, moved, entries) = self.task(graph, task, &before, &mut done);
                let store_s = moved / assumed.store_bytes_s + entries as f64 * assumed.store_latency_s;
                let end_s = launched_s + assumed.begin_s + task_s + store_s;
                free.push(Reverse((end_s * 1e6) as u64));
                wave_s = wave_s.max(end_s);
                wave_bytes += moved;
                busy_s += end_s - launched_s;
            }
            tasks += wave.len();
            // The store serves everyone through one line.
            let wave_s = wave_s.max(wave_bytes / assumed.store_bytes_s);
            waited_s += wave_s - busy_s / nodes as f64;
            (now_s, bytes) = (now_s + wave_s, bytes + wave_bytes);
        }
        let bounds = [
            (self.stage_s.iter().sum::<f64>() / nodes as f64, "work"),
            (waited_s, "waiting for the last task of a wave"),
            (tasks as f64 / assumed.launches_per_s, "launching tasks"),
            (bytes / assumed.store_bytes_s, "store"),
        ];
        let bound = bounds.iter().max_by(|one, other| one.0.total_cmp(&other.0)).map_or("", |bound| bound.1);
        Arrays { wall_s: now_s, bytes, bound }
    }

    /// What a task computes, moves and opens: whatever its stages need that no earlier wave has done.
    fn task(&self, graph: &Graph, task: &[usize], before: &[bool], done: &mut [bool]) -> (f64, f64, usize) {
        let (mut task_s, mut bytes, mut entries) = (0.0, 0.0, 0);
        let mut left: Vec<usize> = task.to_vec();
        let mut seen = std::collections::BTreeSet::new();
        while let Some(stage) = left.pop() {
            if !seen.insert(stage) {
                continue;
            }
            (bytes, entries) = (bytes + self.bytes[stage], entries + 1);
            if !before[stage] {
                task_s += self.stage_s[stage];
                done[stage] = true;
                left.extend(graph.inputs(stage));
            }
        }
        (task_s, bytes, entries)
    }
}
