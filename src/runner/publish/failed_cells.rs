//! Cells of which no trial has a result.

use std::collections::BTreeMap;

use crate::base::Outcome;
use crate::report::Published;
use crate::rows::cell::{CellRow, CellValue};

/// A cell of which every trial failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FailedCell {
    /// Policy, mode, data sizes and training, in words.
    pub cell: String,
    /// Its trials, runs or laps, over all repetitions.
    pub trials: usize,
    /// The failure of the first one.
    pub why: String,
}

/// The outcomes of the trials of each cell.
type CellOutcomes<'a> = BTreeMap<String, Vec<&'a Outcome>>;

/// The cells of one point of a sweep, or of an experiment without one, in which every goal-reaching
/// trial, response, lap or path failed.
pub(super) fn failed_cells(published: &Published) -> Vec<FailedCell> {
    let mut all: Vec<CellOutcomes> = vec![
        by_cell("reach", &published.trials),
        by_cell("response", &published.responses),
        by_cell("pace", &published.paces),
    ];
    let mut paths = CellOutcomes::new();
    for row in &published.tracks {
        // The last sample of a path tells what became of it: an earlier one is `ok`.
        let path = format!("track: policy {}, training {}", row.policy, row.training);
        let outcomes = paths.entry(path).or_default();
        if row.sample.step == 0 || outcomes.is_empty() {
            outcomes.push(&row.sample.status);
        } else if let Some(last) = outcomes.last_mut() {
            *last = &row.sample.status;
        }
    }
    all.push(paths);
    all.into_iter().flatten().filter_map(|(cell, outcomes)| failed(cell, &outcomes)).collect()
}

fn by_cell<'a, T: CellValue>(run: &str, rows: &'a [CellRow<T>]) -> CellOutcomes<'a> {
    let mut cells = CellOutcomes::new();
    for row in rows {
        let mut name = format!(
            "{run}: policy {}, mode {}, training {}",
            row.cell.policy, row.cell.mode, row.training
        );
        for (key, points) in
            [("gp_points", row.cell.gp_points), ("real_points", row.cell.real_points)]
        {
            if points > 0 {
                name.push_str(&format!(", {key} {points}"));
            }
        }
        cells.entry(name).or_default().push(row.value.status());
    }
    cells
}

fn failed(cell: String, outcomes: &[&Outcome]) -> Option<FailedCell> {
    let why = match outcomes {
        [Outcome::Failed(why), ..] if outcomes.iter().all(|outcome| !outcome.is_ok()) => {
            why.clone()
        }
        _ => return None,
    };
    Some(FailedCell { cell, trials: outcomes.len(), why })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::cell::CellLabel;
    use crate::rows::experiment::{ReachTrial, TrackRow, TrackSample};

    fn failure(why: &str) -> Outcome {
        Outcome::Failed(why.to_owned())
    }

    fn trial(policy: &str, status: Outcome) -> CellRow<ReachTrial> {
        let cell = CellLabel {
            policy: policy.to_owned(),
            mode: "open".to_owned(),
            gp_points: 20,
            real_points: 0,
        };
        let value = ReachTrial::new(0, [0.0; 3], [0.0; 3], status);
        CellRow { seed: 0, training: "paper".to_owned(), cell, value }
    }

    fn sample(step: u64, status: Outcome) -> TrackRow {
        let sample = TrackSample { step, ..TrackSample::new([0.0; 3], [0.0; 3], status) };
        TrackRow { seed: 0, training: "paper".to_owned(), policy: "c".to_owned(), sample }
    }

    #[test]
    fn a_cell_is_failed_where_no_trial_has_a_result() {
        let published = Published {
            trials: vec![
                trial("a", failure("lost")),
                trial("a", failure("late")),
                trial("b", Outcome::Ok),
                trial("b", failure("lost")),
            ],
            // One of two paths ended.
            tracks: vec![
                sample(0, Outcome::Ok),
                sample(1, failure("lost")),
                sample(0, Outcome::Ok),
                sample(1, Outcome::Ok),
            ],
            ..Published::default()
        };
        let expected = FailedCell {
            cell: "reach: policy a, mode open, training paper, gp_points 20".to_owned(),
            trials: 2,
            why: "lost".to_owned(),
        };
        assert_eq!(failed_cells(&published), [expected]);
        let lost = Published {
            tracks: vec![sample(0, Outcome::Ok), sample(1, failure("lost"))],
            ..published
        };
        assert_eq!(failed_cells(&lost).len(), 2);
    }
}
