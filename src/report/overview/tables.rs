//! Columns of published tables as the page carries them.

use serde::Serialize;
use std::path::Path;

use crate::data::tables::{Beside, read_text_columns};
use crate::data::{DataError, packed};

/// Significant digits of a number on the page.
const DIGITS: usize = 5;

/// A column: numbers, or text as indices of its distinct values.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub(super) enum Column {
    /// Numbers; `null` for an empty cell.
    Numbers(Vec<Option<f64>>),
    /// Text.
    Text {
        /// The distinct values in the order of their first rows.
        levels: Vec<String>,
        /// The value of each row.
        codes: Vec<usize>,
    },
}

/// Some columns of a published table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct EmbeddedTable {
    /// The file below the folder of `results/`.
    pub(super) file: String,
    /// Its columns by name, in the order of the file.
    pub(super) columns: Vec<(String, Column)>,
}

/// All columns of a published table as text; `None` where it is not there.
///
/// # Errors
/// [`DataError`] for a file that cannot be read.
pub(super) fn published_columns(
    results: &Path,
    file: &str,
) -> Result<Option<Vec<Beside>>, DataError> {
    let path = results.join(file);
    if packed::stored(&path).is_none() {
        return Ok(None);
    }
    read_text_columns(&path).map(Some)
}

impl EmbeddedTable {
    /// The `wanted` columns of the rows in which `keep` holds, which is given a cell by its column.
    pub(super) fn new(
        file: &str,
        columns: &[Beside],
        wanted: &[&str],
        keep: impl Fn(&dyn Fn(&str) -> String) -> bool,
    ) -> EmbeddedTable {
        let count = columns.first().map_or(0, |(_, cells)| cells.len());
        let cell = |name: &str, row: usize| {
            let column = columns.iter().find(|(column, _)| column == name);
            column.map_or_else(String::new, |(_, cells)| cells[row].clone())
        };
        let rows: Vec<usize> =
            (0..count).filter(|&row| keep(&|name: &str| cell(name, row))).collect();
        let embedded = columns
            .iter()
            .filter(|(name, _)| wanted.contains(&name.as_str()))
            .map(|(name, cells)| {
                (name.clone(), Column::of(rows.iter().map(|&row| cells[row].as_str()).collect()))
            })
            .collect();
        EmbeddedTable { file: format!("results/{file}"), columns: embedded }
    }
}

impl Column {
    fn of(cells: Vec<&str>) -> Column {
        let number = |cell: &&str| cell.is_empty() || cell.parse::<f64>().is_ok();
        if cells.iter().all(number) {
            return Column::Numbers(cells.into_iter().map(rounded).collect());
        }
        let mut levels: Vec<String> = Vec::new();
        let codes = cells.into_iter().map(|cell| {
            levels.iter().position(|level| level == cell).unwrap_or_else(|| {
                levels.push(cell.to_owned());
                levels.len() - 1
            })
        });
        let codes = codes.collect();
        Column::Text { levels, codes }
    }
}

/// A number as it is shown; none for an empty cell.
fn rounded(cell: &str) -> Option<f64> {
    let value: f64 = cell.parse().ok()?;
    format!("{value:.*e}", DIGITS - 1).parse().ok().filter(|value: &f64| value.is_finite())
}
