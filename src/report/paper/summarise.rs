//! Rows to summaries: means, standard deviations and intervals over seeds.

use std::collections::{BTreeMap, BTreeSet};

use super::printed;
use crate::base::Outcome;
use crate::math::summary::{mean, oscillation, root_mean_square, standard_deviation};
use crate::report::cells::{CellErrors, SeedError, policy_first, summarise_cells};
use crate::report::order::{rank, trainings};
use crate::report::style::policy_rank;
use crate::rows::experiment::{ReachSummaryRow, TrackRow, TrackSummaryRow, TrialRow};

/// Duration of the windows in which path tracking's oscillation is measured, seconds.
pub const OSCILLATION_WINDOW_S: f64 = 5.0;

/// The error of a trial that ended without failure.
pub(crate) fn trial_error(row: &TrialRow) -> SeedError {
    SeedError::of(row.seed, &row.status, row.error_m)
}

/// Goal-reaching trials, summarised by training, policy, mode and data sizes; in the order of Table
/// I, sizes increasing. The paper's numbers are given for the sizes of Table I (100 points where a
/// sweep includes it), or for the only size.
pub fn reach_summary(trials: &[TrialRow]) -> Vec<ReachSummaryRow> {
    let order = trainings(trials.iter().map(|row| row.training.as_str()));
    let sizes = |row: &TrialRow| {
        let same_policy_and_mode = trials.iter().filter(|other| {
            other.cell.policy == row.cell.policy && other.cell.mode == row.cell.mode
        });
        same_policy_and_mode
            .map(|other| (other.cell.gp_points, other.cell.real_points))
            .collect::<BTreeSet<_>>()
            .len()
    };
    let cells = summarise_cells(
        trials,
        |row| (rank(&order, &row.training), policy_first(&row.cell)),
        trial_error,
    );
    cells.iter().map(|cell| reach_cell(cell, sizes(cell.rows[0]) == 1)).collect()
}

/// One cell; `only`: its policy and mode have a single size.
fn reach_cell(cell: &CellErrors<TrialRow>, only: bool) -> ReachSummaryRow {
    let spreads: Vec<f64> =
        cell.errors_m.values().map(|errors| standard_deviation(errors)).collect();
    let [low_95_m, high_95_m] = cell.interval_95_m();
    let TrialRow { training, cell: label, .. } = cell.rows[0];
    let size_of_paper = label.gp_points == printed::TABLE_1_GP_POINTS
        || label.real_points == printed::TABLE_1_REAL_POINTS
        || only;
    let printed = printed::table_1(&label.policy, &label.mode).filter(|_| size_of_paper);
    let over_trials = |value: fn(&TrialRow) -> f64| {
        mean(&cell.good.iter().map(|row| value(row)).collect::<Vec<_>>())
    };
    ReachSummaryRow {
        training: training.clone(),
        cell: label.clone(),
        mean_m: cell.mean_m(),
        sd_m: root_mean_square(&spreads),
        low_95_m,
        high_95_m,
        seeds: cell.seeds(),
        trials: cell.good.len() as u64,
        failed: cell.failed(),
        settled_share: over_trials(|row| f64::from(u8::from(row.settled))),
        mean_steps: over_trials(|row| row.steps as f64),
        paper_mean_m: printed.map_or(f64::NAN, |printed| printed.mean_m),
        paper_sd_m: printed.map_or(f64::NAN, |printed| printed.sd_m),
    }
}

/// Path tracking, one row for each training, policy and seed.
pub fn track_summary(tracks: &[TrackRow]) -> Vec<TrackSummaryRow> {
    let mut runs: BTreeMap<_, Vec<&TrackRow>> = BTreeMap::new();
    let order = trainings(tracks.iter().map(|row| row.training.as_str()));
    for row in tracks {
        let policy = (policy_rank(&row.policy), row.policy.as_str());
        runs.entry((rank(&order, &row.training), policy, row.seed)).or_default().push(row);
    }
    runs.into_values().map(track_run).collect()
}

/// The error at the end of the first path point, which the robot reaches from home.
fn start_error_m(rows: &[&TrackRow]) -> f64 {
    rows.iter()
        .rev()
        .find(|row| row.sample.path_point == 0)
        .map_or(f64::NAN, |row| row.sample.error_m)
}

fn track_run(mut rows: Vec<&TrackRow>) -> TrackSummaryRow {
    rows.sort_by_key(|row| row.sample.step);
    let errors: Vec<f64> =
        rows.iter().map(|row| row.sample.error_m).filter(|error| error.is_finite()).collect();
    let times: Vec<f64> = rows.iter().map(|row| row.sample.time_s).collect();
    let last_s = times.last().copied().unwrap_or(f64::NAN);
    let step_s = (last_s - times[0]) / (times.len() - 1).max(1) as f64;
    let window = (OSCILLATION_WINDOW_S / step_s).round() as usize;
    let branches: Vec<&str> = rows.iter().map(|row| row.sample.branch.as_str()).collect();
    let failure = rows.iter().map(|row| &row.sample.status).find(|status| !status.is_ok());
    TrackSummaryRow {
        seed: rows[0].seed,
        training: rows[0].training.clone(),
        policy: rows[0].policy.clone(),
        mean_error_m: mean(&errors),
        sd_error_m: standard_deviation(&errors),
        start_error_m: start_error_m(&rows),
        completion_time_s: last_s,
        oscillation_m: oscillation(&errors, window),
        switches: branches.windows(2).filter(|pair| pair[0] != pair[1]).count() as u64,
        steps: rows.len() as u64,
        status: failure.cloned().unwrap_or(Outcome::Ok),
    }
}
