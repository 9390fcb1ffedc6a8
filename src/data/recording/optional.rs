//! Optional columns of a recording: groups that are complete or absent, flags and masses.

use crate::data::DataError;
use crate::data::table::{Cells, Table};

/// Tolerance on a quaternion's length: allows for four decimals in a file.
const UNIT_TOLERANCE: f64 = 1e-2;

/// A group of columns.
pub(super) struct ColumnGroup<'a> {
    pub(super) table: &'a Table,
    pub(super) names: Vec<&'a str>,
    /// Whether the group is required. A group is complete or absent.
    pub(super) required: bool,
    /// Tracking flags of measured columns: where false, a cell may be empty or NaN.
    pub(super) lost: Option<&'a [bool]>,
}

impl ColumnGroup<'_> {
    /// The numbers, `N` per row; NaN where tracking was lost and the cell is empty.
    pub(super) fn read<const N: usize>(&self) -> Result<Option<Vec<[f64; N]>>, DataError> {
        let columns: Vec<Option<&Cells>> =
            self.names.iter().map(|name| self.table.column(name)).collect();
        if !self.required && columns.iter().all(Option::is_none) {
            return Ok(None);
        }
        let mut rows = vec![[f64::NAN; N]; self.table.rows];
        for ((part, name), cells) in self.names.iter().enumerate().zip(&columns) {
            let cells = cells.ok_or_else(|| missing(self.table, name))?;
            for (row, values) in rows.iter_mut().enumerate() {
                match finite(cells, row) {
                    Some(value) => values[part] = value,
                    None if self.is_lost(row) && is_blank(cells, row) => {}
                    None => return Err(self.table.cell_error(row, name, self.expected())),
                }
            }
        }
        Ok(Some(rows))
    }

    /// As [`ColumnGroup::read`], and each row of unit length.
    pub(super) fn quaternions(&self) -> Result<Option<Vec<[f64; 4]>>, DataError> {
        let quaternions = self.read::<4>()?;
        for (row, quaternion) in quaternions.iter().flatten().enumerate() {
            if let Err(length) = unit_length(quaternion) {
                let expected = format!("a unit quaternion (this row's has length {length:.4})");
                return Err(self.table.cell_error(row, self.names[0], expected));
            }
        }
        Ok(quaternions)
    }

    fn is_lost(&self, row: usize) -> bool {
        self.lost.is_some_and(|valid| !valid[row])
    }

    fn expected(&self) -> &'static str {
        match self.lost {
            None => "a number",
            Some(_) => "a number (rows without tracking have valid = 0)",
        }
    }
}

/// Length of a quaternion that is a rotation, or is NaN because tracking was lost.
///
/// # Errors
/// The length, when it differs from 1.
pub(crate) fn unit_length(quaternion: &[f64; 4]) -> Result<f64, f64> {
    let length = quaternion.iter().map(|part| part * part).sum::<f64>().sqrt();
    if (length - 1.0).abs() > UNIT_TOLERANCE { Err(length) } else { Ok(length) }
}

/// The finite number in a cell, if there is one.
pub(super) fn finite(cells: &Cells, row: usize) -> Option<f64> {
    let number = match cells {
        Cells::Integers(cells) => cells[row] as f64,
        Cells::Unsigned(cells) => cells[row] as f64,
        Cells::Numbers(cells) => cells[row],
        Cells::Text(cells) => cells[row].trim().parse().ok()?,
        Cells::Flags(_) => return None,
    };
    number.is_finite().then_some(number)
}

/// Empty or explicitly not a number.
fn is_blank(cells: &Cells, row: usize) -> bool {
    match cells {
        Cells::Numbers(cells) => cells[row].is_nan(),
        Cells::Text(cells) => {
            cells[row].trim().is_empty() || cells[row].trim().eq_ignore_ascii_case("nan")
        }
        _ => false,
    }
}

/// A column of 0 and 1.
pub(super) fn flags(
    table: &Table,
    name: &str,
    expected: &str,
) -> Result<Option<Vec<bool>>, DataError> {
    let Some(cells) = table.column(name) else { return Ok(None) };
    let flag = |row| match cells {
        Cells::Flags(cells) => Ok(cells[row]),
        _ => match finite(cells, row) {
            Some(0.0) => Ok(false),
            Some(1.0) => Ok(true),
            _ => Err(table.cell_error(row, name, expected)),
        },
    };
    (0..table.rows).map(flag).collect::<Result<_, _>>().map(Some)
}

/// A column of masses, kilograms.
pub(super) fn masses(table: &Table, name: &str) -> Result<Option<Vec<f64>>, DataError> {
    let Some(cells) = table.column(name) else { return Ok(None) };
    let mass = |row| {
        let mass = finite(cells, row).filter(|&mass_kg| mass_kg >= 0.0);
        mass.ok_or_else(|| table.cell_error(row, name, "kilograms, 0 or more"))
    };
    (0..table.rows).map(mass).collect::<Result<_, _>>().map(Some)
}

/// A column of labels.
pub(super) fn labels(table: &Table, name: &str) -> Option<Vec<String>> {
    let cells = table.column(name)?;
    let label = |row: usize| match cells {
        Cells::Text(cells) => cells[row].clone(),
        Cells::Flags(cells) => i64::from(cells[row]).to_string(),
        numbers => numbers.show(row),
    };
    Some((0..table.rows).map(label).collect())
}

/// The error for a missing column.
pub(super) fn missing(table: &Table, name: &str) -> DataError {
    table.header_error(name, format!("only {}", table.header()), &format!("a column `{name}`"))
}
