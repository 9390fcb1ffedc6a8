//! Reading a table from a file.

use std::path::Path;

use super::table::{PARQUET, Table, read_parquet};
use super::{DataError, csv, file};

impl Table {
    /// Reads a file, CSV or Parquet by its first bytes.
    pub(crate) fn read(path: &Path) -> Result<Table, DataError> {
        let bytes = file::read(path)?;
        if bytes.starts_with(PARQUET) { read_parquet(path, bytes) } else { csv::read(path, &bytes) }
    }
}
