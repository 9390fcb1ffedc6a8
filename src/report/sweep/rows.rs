//! Rows of a sweep: errors at each point, summarised over seeds.

use std::collections::BTreeMap;

use crate::base::Outcome;
use crate::data::tables::Beside;
use crate::math::summary::standard_deviation;
use crate::report::cells::{CellErrors, SeedError, policy_first, summarise_cells};
use crate::report::order::{rank, trainings};
use crate::report::paper::summarise::trial_error;
use crate::rows::cell::CellLabel;
use crate::rows::experiment::{GpRow, SweepRow, TrackSummaryRow, TrialRow};
use crate::rows::responses::ResponseRow;

/// A summary of a sweep: its rows and the columns of the swept fields.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SweepTable {
    /// Name and cells of each swept field, one cell for each row.
    pub fields: Vec<Beside>,
    /// The summary, the rows of each point together.
    pub rows: Vec<SweepRow>,
}

/// A row of the summary at one point, and what it sums up.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepCell {
    /// The row.
    pub row: SweepRow,
    /// Mean error of each repetition that gave one, metres, by seed.
    pub seed_means_m: BTreeMap<u64, f64>,
}

/// An error at one point, and what it is of.
struct SweptError<'a> {
    training: &'a str,
    cell: CellLabel,
    error: SeedError,
}

/// Goal reaching at one point.
pub fn reach_sweep(trials: &[TrialRow]) -> Vec<SweepCell> {
    summarised(
        "reach",
        trials.iter().map(|row| swept(&row.training, row.cell.clone(), trial_error(row))).collect(),
    )
}

/// Trials of fixed duration at one point: the error of the true tip at their end.
pub fn response_sweep(responses: &[ResponseRow]) -> Vec<SweepCell> {
    let error = |row: &ResponseRow| SeedError::of(row.seed, &row.status, row.error_end_m);
    summarised(
        "response",
        responses.iter().map(|row| swept(&row.training, row.cell.clone(), error(row))).collect(),
    )
}

/// Path tracking at one point; `cell` gives mode and data sizes of a policy.
pub fn track_sweep(runs: &[TrackSummaryRow], cell: impl Fn(&str) -> CellLabel) -> Vec<SweepCell> {
    let error = |row: &TrackSummaryRow| SeedError::of(row.seed, &row.status, row.mean_error_m);
    summarised(
        "track",
        runs.iter().map(|row| swept(&row.training, cell(&row.policy), error(row))).collect(),
    )
}

/// Gaussian processes at one point: no policy takes part.
pub fn gp_sweep(gps: &[GpRow]) -> Vec<SweepCell> {
    let errors = gps.iter().map(|row| {
        let cell = CellLabel { gp_points: row.score.points, ..CellLabel::default() };
        swept(
            &row.training,
            cell,
            SeedError::of(row.seed, &Outcome::Ok, row.score.cross_validation_mae_m),
        )
    });
    summarised("gp", errors.collect())
}

fn swept(training: &str, cell: CellLabel, error: SeedError) -> SweptError<'_> {
    SweptError { training, cell, error }
}

fn summarised(task: &str, errors: Vec<SweptError>) -> Vec<SweepCell> {
    let order = trainings(errors.iter().map(|swept| swept.training));
    let key = |swept: &SweptError| rank(&order, swept.training);
    let cells = summarise_cells(
        &errors,
        |swept| (key(swept), policy_first(&swept.cell)),
        |swept| swept.error,
    );
    let row = |cell: &CellErrors<SweptError>| {
        let seed_means_m = cell.seed_means_m();
        let means: Vec<f64> = seed_means_m.values().copied().collect();
        let [low_95_m, high_95_m] = cell.interval_95_m();
        let row = SweepRow {
            task: task.to_owned(),
            training: cell.rows[0].training.to_owned(),
            cell: cell.rows[0].cell.clone(),
            mean_m: cell.mean_m(),
            sd_over_seeds_m: if means.len() > 1 { standard_deviation(&means) } else { f64::NAN },
            low_95_m,
            high_95_m,
            seeds: cell.seeds(),
            count: cell.rows.len() as u64,
            failed: cell.failed(),
        };
        SweepCell { row, seed_means_m }
    };
    cells.iter().map(row).collect()
}
