//! The cells of an experiment: the product of policies, modes and sizes, each once, in a fixed
//! order.

use super::claims::Size;
use super::repair::RepairRun;
use super::spec::{Experiment, ReachSweep, TrialMode};
use crate::policies;
use crate::rows::cell::CellLabel;

/// The goal-reaching cells.
pub fn reach_cells(experiment: &Experiment) -> Vec<CellLabel> {
    product(experiment, &experiment.runs.reach)
}

/// The cells of responses.
pub fn response_cells(experiment: &Experiment) -> Vec<CellLabel> {
    experiment.runs.response.as_ref().map_or_else(Vec::new, |run| product(experiment, &run.cells))
}

/// The cells of laps.
pub fn pace_cells(experiment: &Experiment) -> Vec<CellLabel> {
    experiment.runs.pace.as_ref().map_or_else(Vec::new, |run| product(experiment, &run.cells))
}

/// The cells of goal reaching before and after changes.
pub fn repair_cells(experiment: &Experiment) -> Vec<CellLabel> {
    experiment.runs.repair.as_ref().map_or_else(Vec::new, |run| product(experiment, &run.cells))
}

/// The policy that works while the robot is watched, as a cell without a mode.
pub fn repair_worker(experiment: &Experiment, run: &RepairRun) -> CellLabel {
    let entry = policies::find_with(&run.worker, &experiment.policies.outside);
    let size = |part: Size, size: usize| {
        if entry.is_some_and(|entry| uses(entry, part)) { size as u64 } else { 0 }
    };
    CellLabel {
        policy: run.worker.clone(),
        mode: String::new(),
        gp_points: size(Size::GpPoints, run.gp_points),
        real_points: size(Size::RealPoints, run.real_points.unwrap_or(0)),
    }
}

/// All cells of trials.
pub fn trial_cells(experiment: &Experiment) -> impl Iterator<Item = CellLabel> {
    let timed = response_cells(experiment).into_iter().chain(pace_cells(experiment));
    let worker = experiment.runs.repair.as_ref().map(|run| repair_worker(experiment, run));
    let repair = repair_cells(experiment).into_iter().chain(worker);
    reach_cells(experiment).into_iter().chain(track_cells(experiment)).chain(timed).chain(repair)
}

fn product(experiment: &Experiment, sweeps: &[ReachSweep]) -> Vec<CellLabel> {
    let mut cells = Vec::new();
    for sweep in sweeps {
        for policy in &sweep.policies {
            let Some(entry) = policies::find_with(policy, &experiment.policies.outside) else {
                continue;
            };
            let open = |mode: &String| experiment.modes.get(mode).is_some_and(TrialMode::is_open);
            for mode in sweep.modes.iter().filter(|mode| !(entry.closed_loop_only && open(mode))) {
                for gp_points in sizes(entry, Size::GpPoints, sweep.gp_points.as_deref()) {
                    for real_points in sizes(entry, Size::RealPoints, sweep.real_points.as_deref())
                    {
                        cells.push(CellLabel {
                            policy: policy.clone(),
                            mode: mode.clone(),
                            gp_points,
                            real_points,
                        });
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
pub fn track_cells(experiment: &Experiment) -> Vec<CellLabel> {
    let Some(track) = &experiment.runs.track else { return Vec::new() };
    let cell = |policy: &String| {
        let entry = policies::find_with(policy, &experiment.policies.outside)?;
        let size = |part: Size, size: Option<usize>| {
            if uses(entry, part) { size.unwrap_or(0) as u64 } else { 0 }
        };
        Some(CellLabel {
            policy: policy.clone(),
            mode: track.mode.clone(),
            gp_points: size(Size::GpPoints, track.gp_points),
            real_points: size(Size::RealPoints, track.real_points),
        })
    };
    track.policies.iter().filter_map(cell).collect()
}

/// Sizes of all Gaussian processes that the experiment fits, ascending.
pub fn gp_sizes(experiment: &Experiment) -> Vec<usize> {
    let monitor = experiment.runs.repair.as_ref().map(|run| run.gp_points);
    let used = trial_cells(experiment)
        .map(|cell| cell.gp_points as usize)
        .chain(monitor)
        .filter(|&points| points > 0);
    let mut sizes: Vec<usize> = used.chain(experiment.runs.gp_points.iter().copied()).collect();
    sizes.sort_unstable();
    sizes.dedup();
    sizes
}

/// The sizes that count for a policy: those given, or a single 0 when it has no such part.
fn sizes(entry: &policies::PolicyEntry, part: Size, sizes: Option<&[usize]>) -> Vec<u64> {
    if uses(entry, part) {
        sizes.unwrap_or_default().iter().map(|&size| size as u64).collect()
    } else {
        vec![0]
    }
}

/// Whether a policy is trained from data of which there may be more or less.
pub(crate) fn uses(entry: &policies::PolicyEntry, size: Size) -> bool {
    match size {
        Size::GpPoints => entry.uses_error_model(),
        Size::RealPoints => entry.uses_real_data(),
    }
}
