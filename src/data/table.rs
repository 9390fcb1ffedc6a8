//! A table as named columns, independent of their meaning; read from CSV and Parquet.

use std::fs::File;
use std::io::{Cursor, Read as _};
use std::path::{Path, PathBuf};

use polars::prelude::{
    Column as Series, CsvReadOptions, CsvWriter, DataFrame, DataType, ParquetReader, ParquetWriter,
    PolarsError, SerReader, SerWriter,
};

use super::DataError;
use super::error::shown;

/// The cells of one column. CSV files yield text, Parquet files also numbers; both are written.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    /// Whole numbers.
    Integers(Vec<i64>),
    /// For numbers that need the whole unsigned range (seeds).
    Unsigned(Vec<u64>),
    /// Not a number where the cell was empty.
    Numbers(Vec<f64>),
    /// True and false.
    Flags(Vec<bool>),
    /// Empty where the cell was empty.
    Text(Vec<String>),
}

impl Cells {
    pub(super) fn len(&self) -> usize {
        match self {
            Cells::Integers(cells) => cells.len(),
            Cells::Unsigned(cells) => cells.len(),
            Cells::Numbers(cells) => cells.len(),
            Cells::Flags(cells) => cells.len(),
            Cells::Text(cells) => cells.len(),
        }
    }

    /// The cell as it would be shown in a message.
    pub(crate) fn show(&self, row: usize) -> String {
        match self {
            Cells::Integers(cells) => cells[row].to_string(),
            Cells::Unsigned(cells) => cells[row].to_string(),
            Cells::Numbers(cells) => cells[row].to_string(),
            Cells::Flags(cells) => cells[row].to_string(),
            Cells::Text(cells) => shown(&cells[row]),
        }
    }

    /// The cell as a CSV file has it.
    pub(super) fn text(&self, row: usize) -> String {
        match self {
            Cells::Numbers(cells) if cells[row].is_nan() => String::new(),
            Cells::Text(cells) => cells[row].clone(),
            other => other.show(row),
        }
    }

    fn into_series(self, name: &str) -> Series {
        match self {
            Cells::Integers(cells) => Series::new(name.into(), cells),
            Cells::Unsigned(cells) => Series::new(name.into(), cells),
            Cells::Numbers(cells) => {
                let cells: Vec<Option<f64>> =
                    cells.into_iter().map(|x| (!x.is_nan()).then_some(x)).collect();
                Series::new(name.into(), cells)
            }
            Cells::Flags(cells) => Series::new(name.into(), cells),
            Cells::Text(cells) => {
                let cells: Vec<Option<String>> =
                    cells.into_iter().map(|text| (!text.is_empty()).then_some(text)).collect();
                Series::new(name.into(), cells)
            }
        }
    }
}

/// Magic bytes of a Parquet file; all other files are read as CSV.
pub(super) const PARQUET: &[u8] = b"PAR1";

/// Whether rows of the file at `path` have line numbers (CSV), for messages. Columns in memory have
/// none: their name is that of no file and has no ending.
pub(crate) fn has_lines(path: &Path) -> bool {
    let mut first = Vec::new();
    let read =
        File::open(path).and_then(|file| file.take(PARQUET.len() as u64).read_to_end(&mut first));
    // A file that was removed since is treated as text.
    first != PARQUET && (read.is_ok() || path.extension().is_some())
}

/// Where row number `row` (from 0) stands, in words.
pub(crate) fn row_place(lines: bool, row: usize) -> String {
    if lines { format!("line {}", row + 2) } else { format!("row {}", row + 1) }
}

/// Where the names stand.
pub(crate) fn header_place(lines: bool) -> &'static str {
    if lines { "line 1" } else { "schema" }
}

/// The columns of a file, all of the same length.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Table {
    pub(crate) file: PathBuf,
    /// Whether a row has a line number (CSV) or only a row number (Parquet).
    pub(crate) lines: bool,
    pub(crate) rows: usize,
    pub(crate) columns: Vec<(String, Cells)>,
}

impl Table {
    /// The cells of the column `name`.
    pub(crate) fn column(&self, name: &str) -> Option<&Cells> {
        self.columns.iter().find(|(column_name, _)| column_name == name).map(|(_, cells)| cells)
    }

    /// Where row number `row` (from 0) stands, in words.
    pub(crate) fn place(&self, row: usize) -> String {
        row_place(self.lines, row)
    }

    /// Where the names stand.
    pub(crate) fn header_place(&self) -> &'static str {
        header_place(self.lines)
    }

    /// The names in the order of the file.
    pub(crate) fn header(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|(name, _)| name.as_str()).collect();
        names.join(", ")
    }

    /// The error for a column of the header.
    pub(crate) fn header_error(&self, column: &str, found: String, expected: &str) -> DataError {
        let (column, expected) = (column.to_owned(), expected.to_owned());
        DataError::Column {
            file: self.file.clone(),
            place: self.header_place(),
            column,
            found,
            expected,
        }
    }

    /// The error for one cell.
    pub(crate) fn cell_error(
        &self,
        row: usize,
        column: &str,
        expected: impl Into<String>,
    ) -> DataError {
        let found = self
            .column(column)
            .map_or_else(|| "no such column".to_owned(), |cells| cells.show(row));
        let (column, place) = (column.to_owned(), self.place(row));
        DataError::Cell { file: self.file.clone(), place, column, found, expected: expected.into() }
    }
}

/// Encodes columns as CSV with the shortest digits that read back unchanged; NaN becomes an empty
/// cell.
pub(crate) fn csv_bytes(columns: Vec<(String, Cells)>) -> Result<Vec<u8>, String> {
    let mut frame = frame(columns)?;
    let mut bytes = Vec::new();
    CsvWriter::new(&mut bytes)
        .n_threads(1)
        .finish(&mut frame)
        .map_err(|error| error.to_string())?;
    Ok(bytes)
}

/// Encodes columns as Parquet.
pub(crate) fn parquet_bytes(columns: Vec<(String, Cells)>) -> Result<Vec<u8>, String> {
    let mut frame = frame(columns)?;
    let mut bytes = Vec::new();
    ParquetWriter::new(&mut bytes)
        .set_parallel(false)
        .finish(&mut frame)
        .map_err(|error| error.to_string())?;
    Ok(bytes)
}

fn frame(columns: Vec<(String, Cells)>) -> Result<DataFrame, String> {
    let series = columns.into_iter().map(|(name, cells)| cells.into_series(&name)).collect();
    DataFrame::new_infer_height(series).map_err(|error| error.to_string())
}

/// Parses checked CSV text (see [`super::csv`]), every column as text; the reader of a format
/// checks the cells.
pub(crate) fn parse_csv(path: &Path, text: &str) -> Result<Table, DataError> {
    let options =
        CsvReadOptions::default().with_infer_schema_length(Some(0)).with_n_threads(Some(1));
    let frame = options.into_reader_with_file_handle(Cursor::new(text.as_bytes())).finish();
    table(path, true, &frame.map_err(|error| unreadable(path, &error))?)
}

pub(super) fn read_parquet(path: &Path, bytes: Vec<u8>) -> Result<Table, DataError> {
    let frame = ParquetReader::new(Cursor::new(bytes))
        .finish()
        .map_err(|error| unreadable(path, &error))?;
    table(path, false, &frame)
}

fn table(path: &Path, lines: bool, frame: &DataFrame) -> Result<Table, DataError> {
    let columns = frame.columns().iter().map(|series| {
        let cells = cells(series).map_err(|error| unreadable(path, &error))?;
        Ok((series.name().to_string(), cells))
    });
    let columns = columns.collect::<Result<_, DataError>>()?;
    Ok(Table { file: path.to_owned(), lines, rows: frame.height(), columns })
}

fn cells(series: &Series) -> Result<Cells, PolarsError> {
    let kind = series.dtype();
    if kind.is_integer() && series.null_count() == 0 {
        let cast = series.strict_cast(&DataType::Int64)?;
        return Ok(Cells::Integers(cast.i64()?.into_no_null_iter().collect()));
    }
    if kind.is_primitive_numeric() {
        let cast = series.cast(&DataType::Float64)?;
        return Ok(Cells::Numbers(
            cast.f64()?.iter().map(|cell| cell.unwrap_or(f64::NAN)).collect(),
        ));
    }
    if kind.is_bool() && series.null_count() == 0 {
        return Ok(Cells::Flags(
            series.bool()?.iter().map(|cell| cell.unwrap_or_default()).collect(),
        ));
    }
    let cast = series.cast(&DataType::String)?;
    Ok(Cells::Text(cast.str()?.iter().map(|cell| cell.unwrap_or_default().to_owned()).collect()))
}

fn unreadable(path: &Path, error: &PolarsError) -> DataError {
    DataError::Read { file: path.to_owned(), reason: error.to_string() }
}
