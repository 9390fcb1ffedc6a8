//! Errors of files: file, place, column, what was found, what was expected.

use std::path::PathBuf;

/// The text of a cell as it is shown in a message.
pub(super) fn shown(cell: &str) -> String {
    if cell.is_empty() { "nothing".to_owned() } else { format!("`{cell}`") }
}

/// Names in a message, at most.
const MAX_LISTED: usize = 12;

/// Names as a message lists them: the first ones, and how many more there are.
pub(super) fn listed(shown: impl IntoIterator<Item = String>) -> String {
    let mut shown = shown.into_iter();
    let mut first: Vec<String> = shown.by_ref().take(MAX_LISTED).collect();
    let more = shown.count();
    first.extend((more > 0).then(|| format!("{more} more")));
    first.join(", ")
}

/// Why a file could not be read or written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DataError {
    /// The operating system refused.
    #[error("{}: cannot read: {reason}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// The operating system refused, or the rows do not form a table.
    #[error("{}: cannot write: {reason}", file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// The file is empty.
    #[error("{}: empty: found {found}, expected {expected}", file.display())]
    Empty {
        /// The file.
        file: PathBuf,
        /// What there was.
        found: &'static str,
        /// What there should have been.
        expected: &'static str,
    },
    /// A line is not a line of a table.
    #[error("{}, {place}: found {found}, expected {expected}", file.display())]
    Line {
        /// The file.
        file: PathBuf,
        /// `line 7` of a CSV (the header is line 1) or `row 6` of a Parquet file.
        place: String,
        /// What stands there.
        found: String,
        /// What should stand there.
        expected: String,
    },
    /// A column is missing, double or out of place.
    #[error("{}, {place}, column `{column}`: found {found}, expected {expected}", file.display())]
    Column {
        /// The file.
        file: PathBuf,
        /// `line 1` of a CSV, `schema` of a Parquet file.
        place: &'static str,
        /// The column.
        column: String,
        /// What the header holds.
        found: String,
        /// What it should hold.
        expected: String,
    },
    /// A cell has a value that its column does not allow.
    #[error("{}, {place}, column `{column}`: found {found}, expected {expected}", file.display())]
    Cell {
        /// The file.
        file: PathBuf,
        /// `line 7` of a CSV (the header is line 1) or `row 6` of a Parquet file.
        place: String,
        /// The column.
        column: String,
        /// What stands there.
        found: String,
        /// What should stand there.
        expected: String,
    },
}
