//! What a run would do with each stage.

use crate::runner::graph::{Graph, StageNode};
use crate::runner::store::Store;

/// What a run would do with a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// Nothing: no stage that must be computed reads it.
    None,
    /// Read it from the store.
    Cached,
    /// Compute it.
    Compute,
}

/// What is needed for the `wanted` stages, judging by the entries that the store has, without
/// reading them.
pub fn plan(graph: &Graph, store: &Store, wanted: &[usize]) -> Vec<Need> {
    plan_with(graph, wanted, |_, node| store.contains(node.kind.name, &node.key))
}

/// Decides for each stage from the last to the first: `stored` is asked only for those that are
/// needed.
pub(crate) fn plan_with(
    graph: &Graph,
    wanted: &[usize],
    mut stored: impl FnMut(usize, &StageNode) -> bool,
) -> Vec<Need> {
    let mut needed = vec![false; graph.nodes.len()];
    wanted.iter().for_each(|&node| needed[node] = true);
    let mut needs = vec![Need::None; graph.nodes.len()];
    for (number, node) in graph.nodes.iter().enumerate().rev() {
        if needed[number] {
            needs[number] = if stored(number, node) { Need::Cached } else { Need::Compute };
            if needs[number] == Need::Compute {
                node.inputs.iter().for_each(|&input| needed[input] = true);
            }
        }
    }
    needs
}
