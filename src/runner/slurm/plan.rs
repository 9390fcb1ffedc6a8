//! Stages put together into the tasks of job arrays, and the arrays into waves, each of which follows the one before.
//!
//! A stage that only one other asks for goes with that one; what costs next to nothing goes with everyone who asks for
//! it. What remains are chains that several others build on: a chain's wave is one more than that of the last it needs.

use crate::runner::graph::Graph;
use crate::runner::plan::Need;
use std::collections::BTreeMap;

/// A chain that costs less than this is computed wherever it is needed, milliseconds: less than it takes to begin a task.
const NEGLIGIBLE_MS: u64 = 50;

/// The stages whose results one array task has to see done; what they need it finds or computes.
pub type Task = Vec<usize>;

/// Puts what must be computed into waves of tasks of about `task_ms` each.
pub fn waves(graph: &Graph, needs: &[Need], task_ms: u64) -> Vec<Vec<Task>> {
    let chains = Chains::new(graph, needs);
    let mut levels: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for root in (0..graph.len()).filter(|&stage| needs[stage] == Need::Compute && chains.ends[stage] == stage) {
        if !chains.follows_along(root) {
            levels.entry(chains.level[root]).or_default().push(root);
        }
    }
    levels.into_values().map(|roots| tasks(&roots, &chains, task_ms)).collect()
}

/// Consecutive chains, until each task has its time.
fn tasks(roots: &[usize], chains: &Chains, task_ms: u64) -> Vec<Task> {
    let mut tasks: Vec<Task> = Vec::new();
    let mut filled_ms = u64::MAX;
    for &root in roots {
        let cost_ms = chains.cost_ms[root];
        match tasks.last_mut() {
            Some(task) if filled_ms.saturating_add(cost_ms) <= task_ms => task.push(root),
            _ => {
                tasks.push(vec![root]);
                filled_ms = 0;
            }
        }
        filled_ms += cost_ms;
    }
    tasks
}

/// Chains of stages, each under the number of the stage that ends it.
struct Chains {
    /// The end of the chain that each stage belongs to.
    ends: Vec<usize>,
    /// Cost of each chain, milliseconds.
    cost_ms: Vec<u64>,
    /// Chains that must be there before, one after the other.
    level: Vec<usize>,
    /// Stages that ask for each.
    asked: Vec<usize>,
}

impl Chains {
    fn new(graph: &Graph, needs: &[Need]) -> Chains {
        let count = graph.len();
        let todo = || (0..count).filter(|&stage| needs[stage] == Need::Compute);
        let (mut asked, mut asker) = (vec![0; count], vec![0; count]);
        for stage in todo() {
            for &input in graph.inputs(stage) {
                asked[input] += 1;
                asker[input] = stage;
            }
        }
        let mut chains = Chains { ends: (0..count).collect(), cost_ms: vec![0; count], level: vec![0; count], asked };
        // Whoever asks comes later, so that from the last to the first the end of the asker's chain is known.
        for stage in todo().collect::<Vec<_>>().into_iter().rev() {
            if chains.asked[stage] == 1 {
                chains.ends[stage] = chains.ends[asker[stage]];
            }
            chains.cost_ms[chains.ends[stage]] += graph.cost_ms(stage);
        }
        for stage in todo() {
            let end = chains.ends[stage];
            for &input in graph.inputs(stage).iter().filter(|&&input| needs[input] == Need::Compute) {
                let other = chains.ends[input];
                if other != end {
                    let step = usize::from(!chains.follows_along(other));
                    chains.level[end] = chains.level[end].max(chains.level[other] + step);
                }
            }
        }
        chains
    }

    /// Whether a chain is so short that everyone who asks for it computes it.
    fn follows_along(&self, end: usize) -> bool {
        self.cost_ms[end] < NEGLIGIBLE_MS && self.asked[end] > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runner::graph::{Handle, StageKind};

    /// A graph of stages with these costs and inputs.
    fn graph(stages: &[(u64, &[usize])]) -> Graph {
        let mut graph = Graph::default();
        for (number, (cost_ms, inputs)) in stages.iter().enumerate() {
            let kind = StageKind { name: "test", sources: &[], cost_ms: *cost_ms };
            let _: Handle<u64> = graph.stage(kind, "", &number, inputs, |_| Ok(1)).unwrap();
        }
        graph
    }

    #[test]
    fn waves_follow_each_other() {
        let graph =
            graph(&[(1000, &[]), (1, &[]), (500, &[0]), (500, &[0]), (100, &[2, 1]), (100, &[3, 1]), (100, &[3])]);
        let needs = [Need::Compute; 7];
        // 2 goes with 4, which alone asks for it; 1 goes with everyone; 3 has two who ask.
        assert_eq!(waves(&graph, &needs, 0), [vec![vec![0]], vec![vec![3], vec![4]], vec![vec![5], vec![6]]]);
        assert_eq!(waves(&graph, &needs, 100_000), [vec![vec![0]], vec![vec![3, 4]], vec![vec![5, 6]]]);
        let mut stored = needs;
        (stored[0], stored[3]) = (Need::Cached, Need::Cached);
        assert_eq!(waves(&graph, &stored, 0), [vec![vec![4], vec![5], vec![6]]]);
        assert!(waves(&graph, &[Need::Cached; 7], 0).is_empty());
    }

    #[test]
    fn every_stage_is_in_reach_of_a_task_that_nothing_later_precedes() {
        // Three layers, everything asks for two of the layer before.
        let mut stages: Vec<(u64, Vec<usize>)> = (0..20).map(|_| (100, vec![])).collect();
        for number in 20..60 {
            let below = number / 20 * 20 - 20;
            stages.push((100, vec![below + number % 20, below + (number * 7 + 3) % 20]));
        }
        let borrowed: Vec<(u64, &[usize])> = stages.iter().map(|(cost, inputs)| (*cost, inputs.as_slice())).collect();
        let graph = graph(&borrowed);
        let mut done = vec![false; graph.len()];
        for wave in waves(&graph, &vec![Need::Compute; graph.len()], 250) {
            let before = done.clone();
            for root in wave.into_iter().flatten() {
                let mut left = vec![root];
                while let Some(stage) = left.pop() {
                    // What a task finds undone is its own: nobody else of its wave needs it.
                    if !before[stage] {
                        assert!(!done[stage] || stage == root, "stage {stage} is computed twice in one wave");
                        done[stage] = true;
                        left.extend(graph.inputs(stage));
                    }
                }
            }
        }
        assert!(done.into_iter().all(|done| done));
    }
}
