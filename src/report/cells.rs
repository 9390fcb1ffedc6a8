//! Rows of one cell together, and their errors by repetition: the one place where rows are grouped
//! for a table.

use std::collections::BTreeMap;

use super::order::{distinct, rank};
use super::style::{policy_markdown, policy_rank};
use crate::math::summary::{interval_95, mean};
use crate::rows::cell::{CellLabel, Outcome};

/// Modes in the order of Table I.
pub(super) const MODES: [&str; 3] = ["open", "closed", "closed_load"];

/// Modes, each once: the paper's in its order, then others by name.
pub(super) fn modes_in_order<'a>(modes: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut modes = distinct(modes);
    modes.sort_by_key(|mode| (rank(&MODES, mode), *mode));
    modes
}

/// A name with its place in the order of tables.
type Ranked<'a> = (usize, &'a str);

/// Place of a cell in tables that list policies first: policy, mode, data sizes increasing.
pub(super) fn policy_first(cell: &CellLabel) -> (Ranked<'_>, Ranked<'_>, (u64, u64)) {
    let (mode, policy, sizes) = mode_first(cell);
    (policy, mode, sizes)
}

/// Place of a cell in tables that list modes first: mode, policy, data sizes increasing.
pub(super) fn mode_first(cell: &CellLabel) -> (Ranked<'_>, Ranked<'_>, (u64, u64)) {
    let mode = (rank(&MODES, &cell.mode), cell.mode.as_str());
    let policy = (policy_rank(&cell.policy), cell.policy.as_str());
    (mode, policy, (cell.gp_points, cell.real_points))
}

/// The error of a row, if it has one.
#[derive(Clone, Copy)]
pub(super) struct SeedError {
    /// Repetition.
    pub(super) seed: u64,
    /// Error, metres; none for a row that failed.
    pub(super) error_m: Option<f64>,
}

impl SeedError {
    /// The error of what went well.
    pub(super) fn of(seed: u64, status: &Outcome, error_m: f64) -> SeedError {
        SeedError { seed, error_m: (status.is_ok() && error_m.is_finite()).then_some(error_m) }
    }
}

/// First cells of a line of a table: policy, training and mode.
pub(super) fn label_cells(training: &str, cell: &CellLabel) -> Vec<String> {
    vec![policy_markdown(&cell.policy).to_owned(), training.to_owned(), cell.mode.clone()]
}

/// The rows of one cell and their errors.
pub(super) struct CellErrors<'a, R> {
    /// All rows: at least one.
    pub(super) rows: Vec<&'a R>,
    /// Those with an error.
    pub(super) good: Vec<&'a R>,
    /// The errors by repetition, metres.
    pub(super) errors_m: BTreeMap<u64, Vec<f64>>,
}

impl<R> CellErrors<'_, R> {
    /// Mean error of each repetition that has one, metres.
    pub(super) fn seed_means_m(&self) -> BTreeMap<u64, f64> {
        self.errors_m.iter().map(|(&seed, errors)| (seed, mean(errors))).collect()
    }

    /// Mean over repetitions of their mean error, metres.
    pub(super) fn mean_m(&self) -> f64 {
        mean(&self.means())
    }

    /// 95 % interval of that mean, metres; not a number for one repetition.
    pub(super) fn interval_95_m(&self) -> [f64; 2] {
        interval_95(&self.means()).unwrap_or([f64::NAN; 2])
    }

    /// Repetitions with an error.
    pub(super) fn seeds(&self) -> u64 {
        self.errors_m.len() as u64
    }

    /// Rows without an error.
    pub(super) fn failed(&self) -> u64 {
        (self.rows.len() - self.good.len()) as u64
    }

    fn means(&self) -> Vec<f64> {
        self.errors_m.values().map(|errors| mean(errors)).collect()
    }
}

/// Groups rows by `key`, in its order, and collects their errors.
pub(super) fn summarise_cells<'a, R, K: Ord>(
    rows: &'a [R],
    key: impl Fn(&'a R) -> K,
    error: impl Fn(&R) -> SeedError,
) -> Vec<CellErrors<'a, R>> {
    let mut cells: BTreeMap<K, CellErrors<R>> = BTreeMap::new();
    for row in rows {
        let empty = || CellErrors { rows: Vec::new(), good: Vec::new(), errors_m: BTreeMap::new() };
        let cell = cells.entry(key(row)).or_insert_with(empty);
        cell.rows.push(row);
        let SeedError { seed, error_m } = error(row);
        if let Some(error_m) = error_m {
            cell.good.push(row);
            cell.errors_m.entry(seed).or_default().push(error_m);
        }
    }
    cells.into_values().collect()
}
