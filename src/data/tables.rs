//! Published tables: rows of plain structs (see [`crate::rows`]) to CSV and back. The fields are
//! the columns, in the order of their declaration. Numbers are rounded to a stated number of
//! significant digits, so that a difference between two published files is a difference in the
//! science and not in the last bit; a number that is not there (NaN) is an empty cell.

use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::row_serde::{FieldValue, RowError, TextRow, fields_of};
use super::table::{Cells, Table, csv_bytes};
use super::{DataError, RecordingSource, write_atomic};

/// Significant digits of a published number: a nanometre in a metre.
pub const SIGNIFICANT_DIGITS: usize = 9;

/// Beginning of the names of columns that are left out where all their cells are empty.
const FURTHER: &str = "further_";

/// `value` rounded to `digits` significant decimal digits.
pub fn round_significant(value: f64, digits: usize) -> f64 {
    if !value.is_finite() || value == 0.0 {
        return value;
    }
    format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(value)
}

/// The bytes of a CSV of these rows.
///
/// # Errors
/// [`DataError::Write`] (with `name` for the file) when there is no row or a field is not a number,
/// text or flag.
pub fn to_csv<R: Serialize>(name: &Path, rows: &[R]) -> Result<Vec<u8>, DataError> {
    to_csv_beside(name, &[], rows)
}

/// A column of text that stands beside the rows: its name and one cell a row.
pub type Beside = (String, Vec<String>);

/// The same with further columns before those of the rows.
///
/// # Errors
/// As [`to_csv`], and when a column does not have one cell a row.
pub fn to_csv_beside<R: Serialize>(
    name: &Path,
    beside: &[Beside],
    rows: &[R],
) -> Result<Vec<u8>, DataError> {
    let refused = |reason: String| DataError::Write { file: name.to_owned(), reason };
    if rows.is_empty() {
        return Err(refused("no rows to write".to_owned()));
    }
    let fields = rows.iter().map(fields_of).collect::<Result<Vec<_>, _>>();
    let fields = fields.map_err(|error| refused(error.to_string()))?;
    // What only some robots have is no column of the others' tables. Stored rows keep every field.
    let is_published = |index: &usize| {
        let empty = |cell: &FieldValue| {
            *cell == FieldValue::Missing || *cell == FieldValue::Text(String::new())
        };
        !(fields[0][*index].0.starts_with(FURTHER)
            && fields.iter().all(|row| empty(&row[*index].1)))
    };
    let columns = (0..fields[0].len()).filter(is_published).map(|index| {
        let name = fields[0][index].0;
        let cells = fields.iter().map(|row| &row[index].1);
        column(cells)
            .map(|cells| (name.to_owned(), cells))
            .ok_or_else(|| format!("column `{name}` mixes kinds"))
    });
    let columns = columns.collect::<Result<Vec<_>, _>>().map_err(refused)?;
    let beside = beside.iter().map(|(name, cells)| (name.clone(), Cells::Text(cells.clone())));
    csv_bytes(beside.chain(columns).collect()).map_err(refused)
}

/// Writes rows to a CSV, the whole file or nothing.
///
/// # Errors
/// As [`to_csv`], and when the file cannot be written.
pub fn write_csv<R: Serialize>(path: &Path, rows: &[R]) -> Result<(), DataError> {
    write_atomic(path, &to_csv(path, rows)?)
}

/// These rows as they read back once they are published.
///
/// # Errors
/// [`DataError::Write`] (with `name` for the file) when a field is not a number, text or flag.
pub fn as_published<R: Serialize + DeserializeOwned>(
    name: &Path,
    rows: &[R],
) -> Result<Vec<R>, DataError> {
    let read_back = |row: &R| {
        let fields = fields_of(row)?;
        let names: Vec<&str> = fields.iter().map(|(name, _)| *name).collect();
        let cells: Vec<String> = fields.iter().map(|(_, cell)| text(cell)).collect();
        let cells: Vec<&str> = cells.iter().map(String::as_str).collect();
        TextRow { names: &names, cells: &cells }.read()
    };
    let rows: Result<Vec<R>, RowError> = rows.iter().map(read_back).collect();
    rows.map_err(|error| DataError::Write { file: name.to_owned(), reason: error.to_string() })
}

/// Reads rows back; the header must be exactly the fields of `R`, less those that have a default:
/// earlier builds knew less.
///
/// # Errors
/// [`DataError`] names file, line, column, what was found and what was expected.
pub fn read_csv<R: DeserializeOwned>(path: &Path) -> Result<Vec<R>, DataError> {
    read_csv_beside(path, |_| false).map(|(_, rows)| rows)
}

/// Reads rows back from a file, or from columns in memory.
///
/// # Errors
/// As [`read_csv`].
pub fn read_rows<R: DeserializeOwned>(source: RecordingSource) -> Result<Vec<R>, DataError> {
    if let RecordingSource::File(path) = source {
        return read_csv(path);
    }
    let table: &Table = &*source.table()?;
    let names: Vec<&str> = table.columns.iter().map(|(name, _)| name.as_str()).collect();
    let rows = (0..table.rows).map(|row| {
        let cells: Vec<String> = table.columns.iter().map(|(_, cells)| cells.text(row)).collect();
        let cells: Vec<&str> = cells.iter().map(String::as_str).collect();
        TextRow { names: &names, cells: &cells }.read().map_err(|error| place(table, row, error))
    });
    rows.collect()
}

/// All columns of a table as text.
///
/// # Errors
/// [`DataError`] for a file that is no table.
pub fn read_text_columns(path: &Path) -> Result<Vec<Beside>, DataError> {
    let text = |(name, cells)| match cells {
        Cells::Text(cells) => Some((name, cells)),
        _ => None,
    };
    Ok(Table::read_text(path)?.columns.into_iter().filter_map(text).collect())
}

/// Reads rows back, and beside them the columns whose name `is_beside` picks.
///
/// # Errors
/// As [`read_csv`].
pub fn read_csv_beside<R: DeserializeOwned>(
    path: &Path,
    is_beside: impl Fn(&str) -> bool,
) -> Result<(Vec<Beside>, Vec<R>), DataError> {
    let table = Table::read_text(path)?;
    let columns = table.columns.iter().filter_map(|(name, cells)| match cells {
        Cells::Text(cells) => Some((name.as_str(), cells)),
        _ => None,
    });
    let (beside, row_columns): (Vec<_>, Vec<_>) = columns.partition(|(name, _)| is_beside(name));
    let (names, columns): (Vec<&str>, Vec<&Vec<String>>) = row_columns.into_iter().unzip();
    let rows = (0..table.rows).map(|row| {
        let cells: Vec<&str> = columns.iter().map(|column| column[row].as_str()).collect();
        TextRow { names: &names, cells: &cells }.read().map_err(|error| place(&table, row, error))
    });
    let rows = rows.collect::<Result<_, DataError>>()?;
    Ok((beside.into_iter().map(|(name, cells)| (name.to_owned(), cells.clone())).collect(), rows))
}

/// Puts a reading error where it belongs.
fn place(table: &Table, row: usize, error: RowError) -> DataError {
    match error {
        RowError::Value { column, expected } => table.cell_error(row, &column, expected),
        RowError::MissingColumn(column) => {
            table.header_error(&column, format!("only {}", table.header()), "this column")
        }
        RowError::UnknownColumn(column) => {
            table.header_error(&column, "it".to_owned(), "no such column")
        }
        RowError::NotFlat(reason) => DataError::Read { file: table.file.clone(), reason },
    }
}

/// One field of all rows as a column; none when the kinds differ.
fn column<'a>(cells: impl Iterator<Item = &'a FieldValue> + Clone) -> Option<Cells> {
    let present = cells.clone().filter(|cell| **cell != FieldValue::Missing);
    let mut kinds = present.map(std::mem::discriminant);
    let kind = kinds.next();
    if !kinds.all(|other| Some(other) == kind) {
        return None;
    }
    let numeric = kind.is_none() || kind == Some(std::mem::discriminant(&FieldValue::Number(0.0)));
    Some(if numeric {
        Cells::Numbers(cells.map(number).collect())
    } else {
        Cells::Text(cells.map(text).collect())
    })
}

/// A published number; none where the cell has none.
fn number(cell: &FieldValue) -> f64 {
    match cell {
        FieldValue::Number(value) => round_significant(*value, SIGNIFICANT_DIGITS),
        _ => f64::NAN,
    }
}

/// A cell as it is published.
fn text(cell: &FieldValue) -> String {
    match cell {
        FieldValue::Number(value) if value.is_nan() => String::new(),
        FieldValue::Number(_) => number(cell).to_string(),
        FieldValue::Integer(value) => value.to_string(),
        FieldValue::Unsigned(value) => value.to_string(),
        FieldValue::Flag(value) => value.to_string(),
        FieldValue::Text(value) => value.clone(),
        FieldValue::Missing => String::new(),
    }
}
