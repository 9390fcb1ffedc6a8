//! Access to columns beyond the format.

use std::path::Path;

use super::{Extra, Recording};
use crate::data::error::shown;
use crate::data::{DataError, table};

impl Recording {
    /// The numbers of a column beyond the format; `None` when there is no such column. `path` is
    /// the file that the recording was read from.
    ///
    /// # Errors
    /// [`DataError::Cell`] for the first cell without a finite number; `expected` describes the
    /// valid values.
    pub fn extra_numbers(
        &self,
        path: &Path,
        name: &str,
        expected: &str,
    ) -> Result<Option<Vec<f64>>, DataError> {
        let Some((_, cells)) = self.extra.iter().find(|(column, _)| column == name) else {
            return Ok(None);
        };
        let number = |row: usize| {
            let (number, cell) = match cells {
                Extra::Integers(cells) => (Some(cells[row] as f64), cells[row].to_string()),
                Extra::Numbers(cells) => (Some(cells[row]), cells[row].to_string()),
                Extra::Text(cells) => (cells[row].trim().parse().ok(), cells[row].clone()),
            };
            number
                .filter(|number: &f64| number.is_finite())
                .ok_or_else(|| cell_error(path, row, name, shown(&cell), expected.to_owned()))
        };
        (0..cells.len()).map(number).collect::<Result<_, _>>().map(Some)
    }
}

/// The error for one cell of a recording that came from `path`.
pub(crate) fn cell_error(
    path: &Path,
    row: usize,
    column: &str,
    found: String,
    expected: String,
) -> DataError {
    let place = table::row_place(table::has_lines(path), row);
    DataError::Cell { file: path.to_owned(), place, column: column.to_owned(), found, expected }
}

/// The error for a column of a recording that came from `path`.
pub(crate) fn column_error(
    path: &Path,
    column: String,
    found: String,
    expected: String,
) -> DataError {
    let place = table::header_place(table::has_lines(path));
    DataError::Column { file: path.to_owned(), place, column, found, expected }
}
