//! Writing a recording.

use std::path::Path;

use super::read::{BASE, BASE_Q, FORCE, GRAVITY, MOMENT, TIP, TIP_Q};
use super::{Extra, Recording};
use crate::data::table::{Cells, csv_bytes, parquet_bytes};
use crate::data::{DataError, write_atomic};

impl Recording {
    /// Checks that a recording can have this name: it ends in `.csv` or `.parquet`, or has no
    /// ending (CSV). The bytes would belie another name.
    ///
    /// # Errors
    /// [`DataError::Write`] for another ending.
    pub fn check_name(path: &Path) -> Result<(), DataError> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        let Some(other) = ending.filter(|ending| !matches!(ending.as_str(), "csv" | "parquet"))
        else {
            return Ok(());
        };
        let reason = format!("found the ending `.{other}`, expected `.csv` or `.parquet`");
        Err(DataError::Write { file: path.to_owned(), reason })
    }

    /// Writes a recording atomically, as Parquet when the name ends in `.parquet`, otherwise as
    /// CSV, with enough digits to read back the same numbers.
    ///
    /// # Errors
    /// [`DataError::Write`] for another ending than `.csv` and `.parquet`, when columns differ in
    /// length, or when the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), DataError> {
        Recording::check_name(path)?;
        let refused = |reason| DataError::Write { file: path.to_owned(), reason };
        let parquet =
            path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("parquet"));
        if !parquet {
            return write_atomic(path, &self.to_csv(path)?);
        }
        let columns = self.columns().map_err(refused)?;
        write_atomic(path, &parquet_bytes(columns).map_err(refused)?)
    }

    /// The recording as CSV.
    ///
    /// # Errors
    /// [`DataError::Write`] with the name `path` when columns differ in length.
    pub fn to_csv(&self, path: &Path) -> Result<Vec<u8>, DataError> {
        let refused = |reason| DataError::Write { file: path.to_owned(), reason };
        csv_bytes(self.columns().map_err(refused)?).map_err(refused)
    }

    /// The columns in the order of the format, then the carried ones; each of the recording's
    /// length.
    ///
    /// # Errors
    /// In words, the column that has another length.
    pub fn columns(&self) -> Result<Vec<(String, Cells)>, String> {
        let rows = self.len();
        let mut columns: Vec<(String, Cells)> = Vec::new();
        columns.push(("trial".to_owned(), Cells::Unsigned(self.trial.clone())));
        columns.push(("time_s".to_owned(), Cells::Numbers(self.time_s.clone())));
        check("time_s", self.time_s.len(), rows)?;
        for drive in &self.drives {
            check(&drive.name, drive.displacement.len(), rows)?;
            columns.push((drive.column(), Cells::Numbers(drive.displacement.clone())));
        }
        if self.drives.is_empty() {
            check("commands", self.commands.len(), rows)?;
            for tendon in 0..self.tendons() {
                let cells = self.commands.iter().map(|row| row[tendon]).collect();
                columns.push((self.actuation.column(tendon), Cells::Numbers(cells)));
            }
        }
        group(&mut columns, &TIP, self.tip_m.as_deref(), |tip| *tip, rows)?;
        group(&mut columns, &TIP_Q, self.tip_quaternion.as_deref(), |turn| *turn, rows)?;
        group(&mut columns, &BASE, self.base.as_deref(), |pose| pose.position_m, rows)?;
        group(&mut columns, &BASE_Q, self.base.as_deref(), |pose| pose.quaternion, rows)?;
        group(
            &mut columns,
            &["known_load_kg"],
            self.known_load_kg.as_deref(),
            |&mass_kg| [mass_kg],
            rows,
        )?;
        for (name, flags) in [("valid", &self.valid), ("at_rest", &self.at_rest)] {
            let Some(flags) = flags else { continue };
            check(name, flags.len(), rows)?;
            let cells = flags.iter().map(|&flag| i64::from(flag)).collect();
            columns.push((name.to_owned(), Cells::Integers(cells)));
        }
        group(&mut columns, &FORCE, self.tip_load.as_deref(), |load| load.force_n, rows)?;
        group(&mut columns, &MOMENT, self.tip_load.as_deref(), |load| load.moment_nm, rows)?;
        group(&mut columns, &GRAVITY, self.gravity_m_s2.as_deref(), |values| *values, rows)?;
        for point in &self.points {
            let (position, turn) = (point.position_columns(), point.quaternion_columns());
            group(
                &mut columns,
                &position.each_ref().map(String::as_str),
                Some(&point.position_m),
                |values| *values,
                rows,
            )?;
            group(
                &mut columns,
                &turn.each_ref().map(String::as_str),
                point.quaternion.as_deref(),
                |values| *values,
                rows,
            )?;
        }
        if let Some(labels) = &self.pattern {
            check("pattern", labels.len(), rows)?;
            columns.push(("pattern".to_owned(), Cells::Text(labels.clone())));
        }
        for (name, cells) in &self.extra {
            check(name, cells.len(), rows)?;
            let cells = match cells {
                Extra::Integers(cells) => Cells::Integers(cells.clone()),
                Extra::Numbers(cells) => Cells::Numbers(cells.clone()),
                Extra::Text(cells) => Cells::Text(cells.clone()),
            };
            columns.push((name.clone(), cells));
        }
        Ok(columns)
    }
}

/// Adds the parts of a group of columns, if the recording has it.
fn group<T, const N: usize>(
    columns: &mut Vec<(String, Cells)>,
    names: &[&str; N],
    values: Option<&[T]>,
    parts: impl Fn(&T) -> [f64; N],
    rows: usize,
) -> Result<(), String> {
    let Some(values) = values else { return Ok(()) };
    check(names[0], values.len(), rows)?;
    for (part, name) in names.iter().enumerate() {
        let cells = values.iter().map(|value| parts(value)[part]).collect();
        columns.push(((*name).to_owned(), Cells::Numbers(cells)));
    }
    Ok(())
}

fn check(name: &str, found: usize, rows: usize) -> Result<(), String> {
    if found == rows {
        Ok(())
    } else {
        Err(format!("column `{name}` has {found} rows, but `trial` has {rows}"))
    }
}
