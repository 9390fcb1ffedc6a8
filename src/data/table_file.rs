//! Reading a table from a file.

use std::path::Path;

use super::table::{PARQUET, Table, read_parquet};
use super::{DataError, csv, file};

/// Magic bytes of zip archives, spreadsheets (.xlsx, .ods) among them.
const ARCHIVE: &[u8] = b"PK\x03\x04";

impl Table {
    /// Reads a file, CSV or Parquet by its first bytes.
    pub(crate) fn read(path: &Path) -> Result<Table, DataError> {
        let bytes = file::read(path)?;
        if bytes.starts_with(ARCHIVE) {
            let found = "a spreadsheet or another zip archive";
            return Err(csv::line_error(path, 1, found, "CSV or Parquet; save the sheet as CSV"));
        }
        let yaml = path.extension().is_some_and(|ending| ending == "yaml" || ending == "yml");
        if yaml {
            return Err(csv::line_error(path, 1, "a YAML file", "a recording, CSV or Parquet"));
        }
        if bytes.starts_with(PARQUET) { read_parquet(path, bytes) } else { csv::read(path, &bytes) }
    }
}
