//! `spinebench compare`.

use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::data::tables::to_csv;
use spinebench::data::write_atomic;
use spinebench::runner::{RunComparison, RunDifference, compare_runs, experiments_of_run};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// Compare the tables of two runs, value by value: verdicts of claims that changed, the largest
/// difference of each table, and the first stage whose result differs. Rows are matched by the
/// columns that identify them. Exit status 1 if anything differs.
#[derive(Args)]
pub(crate) struct CompareCommand {
    /// Folder that a run wrote to (`--out`), or the results of one experiment.
    #[arg(value_name = "FIRST")]
    first: PathBuf,
    /// Folder of the other run, of the same kind.
    #[arg(value_name = "SECOND")]
    second: PathBuf,
    /// Relative tolerance: permitted difference as a share of the larger number.
    #[arg(long, value_name = "SHARE", default_value_t = 0.0)]
    tolerance: f64,
    /// Write every difference to this CSV.
    #[arg(long, value_name = "FILE.csv")]
    out: Option<PathBuf>,
}

impl CompareCommand {
    pub(crate) fn execute(self) -> CommandResult {
        if !(0.0..1.0).contains(&self.tolerance) {
            let found = self.tolerance;
            refuse!("--tolerance: found {found}, expected a number of at least 0 and below 1");
        }
        let [first, second] = [&self.first, &self.second].map(|folder| experiments_of_run(folder));
        for (folder, found) in [(&self.first, &first), (&self.second, &second)] {
            if found.is_empty() {
                let folder = folder.display();
                refuse!("{folder}: found no results, expected a folder that a run wrote to");
            }
        }
        if !first.keys().any(|name| second.contains_key(name)) {
            let names = |found: &BTreeMap<String, PathBuf>| {
                found.keys().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
            };
            refuse!(
                "{}: found {}, expected an experiment of {}: {}",
                self.second.display(),
                names(&second),
                self.first.display(),
                names(&first)
            );
        }
        let comparison =
            compare_runs(&first, &second, self.tolerance).map_err(CommandError::bad_input)?;
        if let Some(file) = &self.out {
            let table = to_csv(file, &comparison.differences).map_err(CommandError::failed)?;
            write_atomic(file, &table).map_err(CommandError::failed)?;
        }
        let lines = lines(&comparison);
        if lines.is_empty() {
            println!("{} tables compared, no differences", comparison.tables);
            return Ok(());
        }
        println!("{} tables compared; first run → second run:", comparison.tables);
        lines.iter().for_each(|line| println!("{line}"));
        Err(CommandError::Answered)
    }
}

/// What differs, in words: verdicts first.
fn lines(comparison: &RunComparison) -> Vec<String> {
    let is_verdict = |difference: &&RunDifference| difference.column.as_deref() == Some("verdict");
    let verdict = |difference: &RunDifference| {
        let text = |value: &Option<String>| value.clone().unwrap_or_default();
        let (before, now) = (text(&difference.first), text(&difference.second));
        format!("{}: {before} → {now}", difference.key)
    };
    let verdicts: BTreeSet<String> =
        comparison.differences.iter().filter(is_verdict).map(verdict).collect();
    let mut by_table: BTreeMap<String, Vec<&RunDifference>> = BTreeMap::new();
    for difference in &comparison.differences {
        let table = difference.table.as_deref().unwrap_or("experiment");
        by_table.entry(format!("{}/{table}", difference.experiment)).or_default().push(difference);
    }
    let mut lines: Vec<String> = verdicts.into_iter().collect();
    lines.extend(by_table.iter().map(|(table, differences)| summary(table, differences)));
    lines.extend(
        comparison.first_stage.iter().map(|stage| format!("first stage that differs: {stage}")),
    );
    lines
}

/// One line a table: how much differs, and the largest share.
fn summary(table: &str, differences: &[&RunDifference]) -> String {
    let share = |difference: &RunDifference| {
        let number = |text: &Option<String>| text.as_ref()?.parse::<f64>().ok().map(f64::abs);
        let larger = number(&difference.first)?.max(number(&difference.second)?);
        Some(difference.difference?.abs() / larger)
    };
    let largest = differences
        .iter()
        .filter_map(|difference| Some((share(difference)?, *difference)))
        .max_by(|one, other| one.0.total_cmp(&other.0));
    let lacking =
        differences.iter().filter(|one| one.first.is_none() || one.second.is_none()).count();
    let mut text = format!("{table}: {} values differ", differences.len() - lacking);
    if lacking > 0 {
        text.push_str(&format!(", {lacking} tables, rows or columns exist in only one run"));
    }
    if let Some((share, one)) = largest {
        let value = |text: &Option<String>| text.clone().unwrap_or_default();
        text.push_str(&format!(
            "; the largest by {:.3} %: {} of {}, {} → {}",
            100.0 * share,
            one.column.as_deref().unwrap_or_default(),
            one.key,
            value(&one.first),
            value(&one.second)
        ));
    }
    text
}
