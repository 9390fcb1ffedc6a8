//! What a recording is read from: a file, or columns in memory.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::DataError;
use super::table::{Cells, Table};

/// Named columns in memory, as a file of the format has them.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordingColumns(Table);

impl RecordingColumns {
    /// Columns that messages call `name`.
    ///
    /// # Errors
    /// [`DataError::Column`] when a name occurs twice or columns differ in length.
    pub fn new(name: &str, columns: Vec<(String, Cells)>) -> Result<RecordingColumns, DataError> {
        let rows = columns.first().map_or(0, |(_, cells)| cells.len());
        let table = Table { file: PathBuf::from(name), lines: false, rows, columns };
        let mut names = BTreeSet::new();
        for (column, cells) in &table.columns {
            if !names.insert(column) {
                return Err(table.header_error(column, "it twice".to_owned(), "each column once"));
            }
            if cells.len() != rows {
                let expected = format!("{rows}, as in the first column");
                return Err(table.header_error(column, format!("{} rows", cells.len()), &expected));
            }
        }
        Ok(RecordingColumns(table))
    }
}

/// What a recording is read from.
#[derive(Clone, Copy, Debug)]
pub enum RecordingSource<'a> {
    /// A CSV or Parquet file.
    File(&'a Path),
    /// Columns in memory.
    Columns(&'a RecordingColumns),
}

impl<'a> RecordingSource<'a> {
    /// The file, or what stands for it in messages.
    pub fn name(self) -> &'a Path {
        match self {
            RecordingSource::File(path) => path,
            RecordingSource::Columns(columns) => &columns.0.file,
        }
    }

    pub(super) fn table(self) -> Result<Cow<'a, Table>, DataError> {
        match self {
            RecordingSource::File(path) => Table::read(path).map(Cow::Owned),
            RecordingSource::Columns(columns) => Ok(Cow::Borrowed(&columns.0)),
        }
    }
}

impl<'a> From<&'a Path> for RecordingSource<'a> {
    fn from(path: &'a Path) -> RecordingSource<'a> {
        RecordingSource::File(path)
    }
}

impl<'a> From<&'a PathBuf> for RecordingSource<'a> {
    fn from(path: &'a PathBuf) -> RecordingSource<'a> {
        RecordingSource::File(path)
    }
}

impl<'a> From<&'a RecordingColumns> for RecordingSource<'a> {
    fn from(columns: &'a RecordingColumns) -> RecordingSource<'a> {
        RecordingSource::Columns(columns)
    }
}
