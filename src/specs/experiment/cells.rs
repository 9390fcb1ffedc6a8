//! The cells of an experiment: the product of policies, modes and sizes, each once, in a fixed order.

use super::spec::{Experiment, TrialMode};
use crate::policies::{self, Part};

/// Trials of one policy in one mode: a set of targets for each seed and training.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct TrialCell {
    /// Policy.
    pub policy: String,
    /// Mode.
    pub mode: String,
    /// Real points of the Gaussian process; 0 for policies without one.
    pub gp_points: usize,
    /// Real points of the network; 0 for policies without one.
    pub real_points: usize,
}

/// The goal-reaching cells.
pub fn reach_cells(experiment: &Experiment) -> Vec<TrialCell> {
    let mut cells = Vec::new();
    for sweep in &experiment.runs.reach {
        for policy in &sweep.policies {
            let Some(entry) = policies::find(policy) else { continue };
            let open = |mode: &String| experiment.modes.get(mode).is_some_and(TrialMode::is_open);
            for mode in sweep.modes.iter().filter(|mode| !(entry.closed_loop_only && open(mode))) {
                for gp_points in sizes(entry, Part::Error, sweep.gp_points.as_deref()) {
                    for real_points in sizes(entry, Part::RealInverse, sweep.real_points.as_deref()) {
                        cells.push(TrialCell { policy: policy.clone(), mode: mode.clone(), gp_points, real_points });
                    }
                }
            }
        }
    }
    cells.sort();
    cells.dedup();
    cells
}

/// The path-tracking cells, one for each policy.
pub fn track_cells(experiment: &Experiment) -> Vec<TrialCell> {
    let Some(track) = &experiment.runs.track else { return Vec::new() };
    let cell = |policy: &String| {
        let entry = policies::find(policy)?;
        let size = |part: Part, size: Option<usize>| if uses(entry, part) { size.unwrap_or(0) } else { 0 };
        Some(TrialCell {
            policy: policy.clone(),
            mode: track.mode.clone(),
            gp_points: size(Part::Error, track.gp_points),
            real_points: size(Part::RealInverse, track.real_points),
        })
    };
    track.policies.iter().filter_map(cell).collect()
}

/// Sizes of all Gaussian processes that the experiment fits, ascending.
pub fn gp_sizes(experiment: &Experiment) -> Vec<usize> {
    let cells = reach_cells(experiment).into_iter().chain(track_cells(experiment));
    let used = cells.map(|cell| cell.gp_points).filter(|&points| points > 0);
    let mut sizes: Vec<usize> = used.chain(experiment.runs.gp_points.iter().copied()).collect();
    sizes.sort_unstable();
    sizes.dedup();
    sizes
}

/// The sizes that apply to a policy: the given ones, or a single 0 when it has no such part.
fn sizes(entry: &policies::PolicyEntry, part: Part, given: Option<&[usize]>) -> Vec<usize> {
    if uses(entry, part) { given.unwrap_or_default().to_vec() } else { vec![0] }
}

/// Whether a policy is built from `part`, directly or through another part (generated data come from the error model).
pub(in crate::specs) fn uses(entry: &policies::PolicyEntry, part: Part) -> bool {
    entry.needs.iter().any(|need| *need == part || (part == Part::Error && *need == Part::GeneratedInverse))
}
