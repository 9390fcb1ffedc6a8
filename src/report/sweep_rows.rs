//! Rows of a sweep: errors at each point, summarised over seeds.

use std::collections::BTreeMap;

use super::order::{rank, trainings};
use super::style::policy_rank;
use super::summarise::MODES;
use crate::data::responses::ResponseRow;
use crate::data::rows::{GpRow, SweepRow, TrackSummaryRow, TrialRow};
use crate::data::tables::Beside;
use crate::math::summary::{interval_95, mean, standard_deviation};

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

/// Key of a cell, in the order of the table.
type CellKey<'a> = (usize, &'a str, usize, &'a str, usize, &'a str, [u64; 2]);

/// The seed of a trial, run or process, and its error in metres, if any.
type SeedError = (u64, Option<f64>);

/// Training, policy and mode of an error, its real points, and the error with its seed.
type SweptError<'a> = ([&'a str; 3], [u64; 2], SeedError);

/// Goal reaching at one point.
pub fn reach_sweep(trials: &[TrialRow]) -> Vec<SweepCell> {
    let samples = trials.iter().map(|row| {
        let names = [row.training.as_str(), &row.policy, &row.mode];
        (names, [row.gp_points, row.real_points], (row.seed, good(&row.status, row.error_m)))
    });
    summarised("reach", samples.collect())
}

/// Trials of fixed duration at one point: the error of the true tip at their end.
pub fn response_sweep(responses: &[ResponseRow]) -> Vec<SweepCell> {
    let samples = responses.iter().map(|row| {
        let names = [row.training.as_str(), &row.policy, &row.mode];
        (names, [row.gp_points, row.real_points], (row.seed, good(&row.status, row.error_end_m)))
    });
    summarised("response", samples.collect())
}

/// Path tracking at one point; `sizes` are each policy's real points, those of the Gaussian process first.
pub fn track_sweep(runs: &[TrackSummaryRow], mode: &str, sizes: impl Fn(&str) -> [u64; 2]) -> Vec<SweepCell> {
    let samples = runs.iter().map(|row| {
        let names = [row.training.as_str(), &row.policy, mode];
        (names, sizes(&row.policy), (row.seed, good(&row.status, row.mean_error_m)))
    });
    summarised("track", samples.collect())
}

/// Gaussian processes at one point.
pub fn gp_sweep(gps: &[GpRow]) -> Vec<SweepCell> {
    let samples = gps.iter().map(|row| {
        ([row.training.as_str(), "", ""], [row.points, 0], (row.seed, good("ok", row.cross_validation_mae_m)))
    });
    summarised("gp", samples.collect())
}

/// The error of what went well.
fn good(status: &str, error_m: f64) -> Option<f64> {
    (status == "ok" && error_m.is_finite()).then_some(error_m)
}

fn summarised(task: &str, samples: Vec<SweptError>) -> Vec<SweepCell> {
    let order = trainings(samples.iter().map(|([training, ..], ..)| *training));
    let mut cells: BTreeMap<CellKey, Vec<SeedError>> = BTreeMap::new();
    for (names, sizes, error) in samples {
        cells.entry(cell(&order, names, sizes)).or_default().push(error);
    }
    rows(task, cells)
}

fn cell<'a>(kinds: &[&str], [training, policy, mode]: [&'a str; 3], sizes: [u64; 2]) -> CellKey<'a> {
    (rank(kinds, training), training, policy_rank(policy), policy, rank(&MODES, mode), mode, sizes)
}

fn rows(task: &str, cells: BTreeMap<CellKey, Vec<SeedError>>) -> Vec<SweepCell> {
    let row = |((_, training, _, policy, _, mode, [gp_points, real_points]), samples): (CellKey, Vec<SeedError>)| {
        let mut seeds: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
        for (seed, error_m) in &samples {
            seeds.entry(*seed).or_default().extend(error_m);
        }
        seeds.retain(|_, errors| !errors.is_empty());
        let seed_means_m: BTreeMap<u64, f64> = seeds.into_iter().map(|(seed, errors)| (seed, mean(&errors))).collect();
        let means: Vec<f64> = seed_means_m.values().copied().collect();
        let [low_95_m, high_95_m] = interval_95(&means).unwrap_or([f64::NAN; 2]);
        let row = SweepRow {
            task: task.to_owned(),
            training: training.to_owned(),
            policy: policy.to_owned(),
            mode: mode.to_owned(),
            gp_points,
            real_points,
            mean_m: mean(&means),
            sd_over_seeds_m: if means.len() > 1 { standard_deviation(&means) } else { f64::NAN },
            low_95_m,
            high_95_m,
            seeds: means.len() as u64,
            count: samples.len() as u64,
            failed: samples.iter().filter(|(_, error_m)| error_m.is_none()).count() as u64,
        };
        SweepCell { row, seed_means_m }
    };
    cells.into_iter().map(row).collect()
}
