//! The command log, with the time of each row on the tracker's clock.

use std::path::{Path, PathBuf};

use crate::data::recording::{cell_error, column_error};
use crate::data::{DataError, Recording};

/// Time of a row in the export, seconds.
pub(crate) const EXPORT_TIME: &str = "export_time_s";
/// Time of a row on one clock for all trials, seconds, arbitrary origin.
const WALL_TIME: &str = "wall_time_s";

/// Allowed difference of the two clocks within a trial, seconds, …
const MAX_JITTER_S: f64 = 0.1;
/// … and as a share of the time since its start.
const MAX_RATE_ERROR: f64 = 0.01;

/// Commands with their times.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// The file that they came from.
    pub file: PathBuf,
    /// The commands.
    pub commands: Recording,
    /// Time of each command on the export's clock, seconds.
    pub at_s: Vec<f64>,
}

impl Log {
    /// Reads a log. Rows are placed in time by the column `export_time_s`, or else by `offsets_s`:
    /// the export time of the first row, with a column `wall_time_s` for the others, or of the
    /// first row of each trial.
    ///
    /// # Errors
    /// [`DataError`] when the file is not a recording or its time in the export is unknown.
    pub fn read(path: &Path, offsets_s: &[f64]) -> Result<Log, DataError> {
        let commands = Recording::read_commands(path)?;
        let at_s = export_times(path, &commands, offsets_s)?;
        check_pace(path, &commands, &at_s)?;
        Ok(Log { file: path.to_owned(), commands, at_s })
    }
}

/// Refuses times that do not increase or that run at another rate than the trial's `time_s`:
/// milliseconds, or planned instead of actual times.
fn check_pace(path: &Path, commands: &Recording, at_s: &[f64]) -> Result<(), DataError> {
    let column =
        [EXPORT_TIME, WALL_TIME].into_iter().find(|name| has(commands, name)).unwrap_or("time_s");
    let wrong = |row, found, expected| Err(cell_error(path, row, column, found, expected));
    for (_, rows) in commands.trials() {
        for row in rows.clone() {
            let (in_export_s, in_trial_s) = (at_s[row] - at_s[rows.start], commands.time_s[row]);
            if row > 0 && at_s[row] <= at_s[row - 1] {
                let expected =
                    format!("more than {:.6} s, the time of the previous row", at_s[row - 1]);
                return wrong(row, format!("{:.6} s in the export", at_s[row]), expected);
            }
            if (in_export_s - in_trial_s).abs() > MAX_JITTER_S + MAX_RATE_ERROR * in_trial_s {
                let expected = format!("about {in_trial_s} s, as in `time_s`");
                return wrong(
                    row,
                    format!("{in_export_s:.6} s after the trial's first row"),
                    expected,
                );
            }
        }
    }
    Ok(())
}

fn has(commands: &Recording, name: &str) -> bool {
    commands.extra.iter().any(|(column, _)| column == name)
}

fn export_times(
    path: &Path,
    commands: &Recording,
    offsets_s: &[f64],
) -> Result<Vec<f64>, DataError> {
    if let Some(at_s) =
        commands.extra_numbers(path, EXPORT_TIME, "seconds in the export, a number")?
    {
        let found = "the time of each row, and also --offset-s";
        return if offsets_s.is_empty() {
            Ok(at_s)
        } else {
            Err(unplaced(path, found.to_owned(), "one of the two"))
        };
    }
    let trials = commands.trials();
    match offsets_s {
        [] => {
            let expected = "the time of each row in the export, or --offset-s";
            Err(unplaced(path, "no such column".to_owned(), expected))
        }
        [offset_s] if has(commands, WALL_TIME) => {
            let wall_s =
                commands.extra_numbers(path, WALL_TIME, "seconds, a number")?.unwrap_or_default();
            Ok(wall_s.iter().map(|now_s| now_s - wall_s[0] + offset_s).collect())
        }
        _ if offsets_s.len() == trials.len() => {
            let rows = trials.iter().zip(offsets_s).flat_map(|((_, rows), offset_s)| {
                rows.clone().map(move |row| commands.time_s[row] + offset_s)
            });
            Ok(rows.collect())
        }
        _ => {
            let found =
                format!("no such column, {} trials and {} offsets", trials.len(), offsets_s.len());
            let expected =
                "one --offset-s for each trial (or one and a column `wall_time_s`), or this column";
            Err(unplaced(path, found, expected))
        }
    }
}

fn unplaced(path: &Path, found: String, expected: &str) -> DataError {
    column_error(path, EXPORT_TIME.to_owned(), found, expected.to_owned())
}
