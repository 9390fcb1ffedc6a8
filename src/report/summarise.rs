//! Rows to summaries: means, standard deviations and intervals over seeds.

use std::collections::{BTreeMap, BTreeSet};

use super::order::{distinct, rank, trainings};
use super::paper;
use super::style::policy_rank;
use crate::data::rows::{ReachSummaryRow, TrackRow, TrackSummaryRow, TrialRow};
use crate::math::summary::{interval_95, mean, oscillation, root_mean_square, standard_deviation};

/// Modes in the order of Table I.
pub(super) const MODES: [&str; 3] = ["open", "closed", "closed_load"];

/// Modes, each once: the paper's in its order, then others by name.
pub(super) fn modes_in_order<'a>(modes: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut found = distinct(modes);
    found.sort_by_key(|mode| (rank(&MODES, mode), *mode));
    found
}

/// Duration of the windows in which path tracking's oscillation is measured, seconds.
pub const OSCILLATION_WINDOW_S: f64 = 5.0;

/// Goal-reaching trials, summarised by training, policy, mode and data sizes; in the order of Table I, sizes increasing.
/// The paper's numbers are given for the sizes of Table I (100 points where a sweep includes it), or for the only size.
pub fn reach_summary(trials: &[TrialRow]) -> Vec<ReachSummaryRow> {
    let mut cells: BTreeMap<_, Vec<&TrialRow>> = BTreeMap::new();
    let order = trainings(trials.iter().map(|row| row.training.as_str()));
    for row in trials {
        let key = (
            rank(&order, &row.training),
            (policy_rank(&row.policy), row.policy.as_str()),
            (rank(&MODES, &row.mode), row.mode.as_str()),
            (row.gp_points, row.real_points),
        );
        cells.entry(key).or_default().push(row);
    }
    let sizes = |row: &TrialRow| {
        let same = trials.iter().filter(|other| other.policy == row.policy && other.mode == row.mode);
        same.map(|other| (other.gp_points, other.real_points)).collect::<BTreeSet<_>>().len()
    };
    cells.values().map(|rows| reach_cell(rows, sizes(rows[0]) == 1)).collect()
}

/// One cell; `only`: its policy and mode have a single size.
fn reach_cell(rows: &[&TrialRow], only: bool) -> ReachSummaryRow {
    let mut errors: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    let good: Vec<&&TrialRow> = rows.iter().filter(|row| row.status == "ok" && row.error_m.is_finite()).collect();
    for row in &good {
        errors.entry(row.seed).or_default().push(row.error_m);
    }
    let means: Vec<f64> = errors.values().map(|errors| mean(errors)).collect();
    let spreads: Vec<f64> = errors.values().map(|errors| standard_deviation(errors)).collect();
    let [low_95_m, high_95_m] = interval_95(&means).unwrap_or([f64::NAN; 2]);
    let first = rows[0];
    let size_of_paper =
        first.gp_points == paper::TABLE_1_GP_POINTS || first.real_points == paper::TABLE_1_REAL_POINTS || only;
    let printed = paper::table_1(&first.policy, &first.mode).filter(|_| size_of_paper);
    ReachSummaryRow {
        training: first.training.clone(),
        policy: first.policy.clone(),
        mode: first.mode.clone(),
        gp_points: first.gp_points,
        real_points: first.real_points,
        mean_m: mean(&means),
        sd_m: root_mean_square(&spreads),
        low_95_m,
        high_95_m,
        seeds: errors.len() as u64,
        trials: good.len() as u64,
        failed: (rows.len() - good.len()) as u64,
        settled_share: mean(&good.iter().map(|row| f64::from(u8::from(row.settled))).collect::<Vec<_>>()),
        mean_steps: mean(&good.iter().map(|row| row.steps as f64).collect::<Vec<_>>()),
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
    rows.iter().rev().find(|row| row.path_point == 0).map_or(f64::NAN, |row| row.error_m)
}

fn track_run(mut rows: Vec<&TrackRow>) -> TrackSummaryRow {
    rows.sort_by_key(|row| row.step);
    let errors: Vec<f64> = rows.iter().map(|row| row.error_m).filter(|error| error.is_finite()).collect();
    let times: Vec<f64> = rows.iter().map(|row| row.time_s).collect();
    let last_s = times.last().copied().unwrap_or(f64::NAN);
    let step_s = (last_s - times[0]) / (times.len() - 1).max(1) as f64;
    let window = (OSCILLATION_WINDOW_S / step_s).round() as usize;
    let branches: Vec<&str> = rows.iter().map(|row| row.branch.as_str()).collect();
    let failure = rows.iter().find(|row| row.status != "ok");
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
        status: failure.map_or_else(|| "ok".to_owned(), |row| row.status.clone()),
    }
}
