//! Published tables as Parquet, a fifth of the size. A table is `x.csv` or `x.parquet`; where both
//! lie there, a run has just written the CSV.

use std::path::{Path, PathBuf};

use super::table::{Cells, PARQUET, Table, csv_bytes, parquet_bytes, read_parquet};
use super::{DataError, csv, file, write_atomic};

/// Where the table `x.csv` is stored: there, or in `x.parquet`. None where neither is.
pub fn stored(path: &Path) -> Option<PathBuf> {
    let is_csv = path.extension().is_some_and(|ending| ending == "csv");
    let packed = is_csv.then(|| path.with_extension("parquet"));
    [Some(path.to_owned()), packed].into_iter().flatten().find(|path| path.is_file())
}

/// The bytes of the table `x.csv`, whichever way it is stored.
///
/// # Errors
/// [`DataError::Read`] where it is not there or cannot be unpacked.
pub fn csv_of(path: &Path) -> Result<Vec<u8>, DataError> {
    let path = stored(path).unwrap_or_else(|| path.to_owned());
    let bytes = file::read(&path)?;
    if !bytes.starts_with(PARQUET) {
        return Ok(bytes);
    }
    let table = read_parquet(&path, bytes)?;
    csv_bytes(table.columns).map_err(|reason| DataError::Read { file: path, reason })
}

/// Writes `x.parquet` beside `x.csv`, from which the same bytes come back. One that already gives
/// them stays as it is.
///
/// # Errors
/// [`DataError`] for a file that is no table, or one whose bytes would not come back.
pub fn pack(path: &Path) -> Result<(), DataError> {
    let (bytes, packed) = (file::read(path)?, path.with_extension("parquet"));
    if csv_of(&packed).is_ok_and(|before| before == bytes) {
        return Ok(());
    }
    let refused = |reason: String| DataError::Write { file: packed.clone(), reason };
    let table = csv::read(path, &bytes)?;
    let columns = table.columns.into_iter().map(|(name, cells)| (name, as_numbers(cells)));
    let parquet = parquet_bytes(columns.collect()).map_err(refused)?;
    let columns = read_parquet(&packed, parquet.clone())?.columns;
    if csv_bytes(columns).map_err(refused)? != bytes {
        return Err(refused(format!("cannot hold {} to the byte", path.display())));
    }
    write_atomic(&packed, &parquet)
}

/// Writes `x.csv` beside `x.parquet`.
///
/// # Errors
/// [`DataError`] for a file that cannot be read or written.
pub fn unpack(path: &Path) -> Result<(), DataError> {
    write_atomic(&path.with_extension("csv"), &csv_of(path)?)
}

/// The cells of a CSV as numbers, where these are written as the same text.
fn as_numbers(cells: Cells) -> Cells {
    let Cells::Text(texts) = &cells else { return cells };
    let integers: Option<Vec<i64>> = texts.iter().map(|text| text.parse().ok()).collect();
    let number = |text: &String| if text.is_empty() { Some(f64::NAN) } else { text.parse().ok() };
    let numbers: Option<Vec<f64>> = texts.iter().map(number).collect();
    let csv = |cells: &Cells| csv_bytes(vec![("column".to_owned(), cells.clone())]);
    let text = csv(&cells);
    let kinds = [integers.map(Cells::Integers), numbers.map(Cells::Numbers)];
    kinds.into_iter().flatten().find(|numbers| csv(numbers) == text).unwrap_or(cells)
}

impl Table {
    /// Reads a table whose cells are text, as those of a CSV are, whichever way it is stored.
    pub(super) fn read_text(path: &Path) -> Result<Table, DataError> {
        let table = Table::read(&stored(path).unwrap_or_else(|| path.to_owned()))?;
        if table.lines {
            return Ok(table);
        }
        let refused = |reason| DataError::Read { file: table.file.clone(), reason };
        let bytes = csv_bytes(table.columns).map_err(refused)?;
        Ok(Table { lines: false, ..csv::read(&table.file, &bytes)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn every_kind_of_cell_comes_back_to_the_byte() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.csv");
        let text = "seed,name,size_m,ok,note,few,gp.kernel,none\n\
                    18446744073709551615,\"a, \"\"b\"\"\",0.1,true,,3,1e-3,\n\
                    2,c,-1.23456789e-12,false,007,,matern52,\n\
                    3,d,-0.0,true,x,-4,0.10,\n";
        fs::write(&path, text).unwrap();
        let packed = path.with_extension("parquet");
        pack(&path).unwrap();
        assert_eq!(stored(&path), Some(path.clone()), "the CSV is the newer one");
        fs::remove_file(&path).unwrap();
        assert_eq!(stored(&path), Some(packed.clone()));
        assert_eq!(String::from_utf8(csv_of(&path).unwrap()).unwrap(), text);
        unpack(&packed).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), text);
        let first = fs::read(&packed).unwrap();
        fs::remove_file(&packed).unwrap();
        pack(&path).unwrap();
        assert!(fs::read(&packed).unwrap() == first, "the same rows give the same bytes");
        // Not as this program writes it: what was packed stays as it is.
        fs::write(&path, text.replace("18446744073709551615", "\"5\"")).unwrap();
        assert!(pack(&path).unwrap_err().to_string().contains("to the byte"));
        assert!(fs::read(&packed).unwrap() == first);
    }
}
