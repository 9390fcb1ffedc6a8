//! Bodies in the columns of a table, frame by frame.

use std::collections::BTreeMap;

use crate::data::DataError;
use crate::data::import::mapped::LogTable;
use crate::data::import::{Body, Export};
use crate::data::recording::{Pose, unit_length};

/// Columns of a body.
#[derive(Clone, Debug)]
pub(super) struct ExportColumns {
    pub(super) name: String,
    /// x, y and z.
    pub(super) position: [usize; 3],
    /// Metres in the unit of the position.
    pub(super) unit_m: f64,
    pub(super) orientation: OrientationCells,
    /// A column, and the texts in it (in lower case) of a tracked body.
    pub(super) status: Option<(usize, &'static [&'static str])>,
}

/// Columns of an orientation.
#[derive(Clone, Copy, Debug)]
pub(super) enum OrientationCells {
    /// A single marker.
    None,
    /// w, x, y, z.
    Quaternion([usize; 4]),
    /// The elements of the rotation matrix, column by column.
    Matrix([usize; 9]),
}

/// Bodies of one table at the times of its rows.
pub(super) struct TableBodies<'a> {
    pub(super) table: &'a LogTable,
    pub(super) time_s: Vec<f64>,
    pub(super) columns: Vec<ExportColumns>,
}

/// The bodies of tables of one clock as an export.
///
/// # Errors
/// [`DataError`] for a cell that is no number, an orientation that is none, times that do not
/// increase, and tables without bodies.
pub(super) fn export(tables: &[TableBodies], names_place: String) -> Result<Export, DataError> {
    const ROUNDING: f64 = 1e9;
    let mut rows: BTreeMap<i64, f64> = BTreeMap::new();
    for TableBodies { table, time_s, .. } in tables {
        if let Some(row) = (1..time_s.len()).find(|&row| time_s[row] <= time_s[row - 1]) {
            return Err(DataError::Line {
                file: table.file.clone(),
                place: table.place(row),
                found: format!("the time {} s", time_s[row]),
                expected: format!(
                    "more than {} s, the time of the previous frame",
                    time_s[row - 1]
                ),
            });
        }
        rows.extend(time_s.iter().map(|time_s| ((time_s * ROUNDING).round() as i64, *time_s)));
    }
    let times: Vec<i64> = rows.keys().copied().collect();
    let (mut bodies, mut markers) = (Vec::new(), Vec::new());
    for TableBodies { table, time_s, columns } in tables {
        let places = time_s
            .iter()
            .map(|time_s| times.partition_point(|time| *time < (time_s * ROUNDING).round() as i64));
        let places: Vec<usize> = places.collect();
        for body in columns {
            let mut poses = vec![None; times.len()];
            for (row, place) in places.iter().enumerate() {
                poses[*place] = pose(table, body, row)?;
            }
            let has_orientation = !matches!(body.orientation, OrientationCells::None);
            let kind = if has_orientation { &mut bodies } else { &mut markers };
            kind.push(Body { name: body.name.clone(), has_orientation, poses });
        }
    }
    let file = tables.first().map(|table| table.table.file.clone()).unwrap_or_default();
    let mut export = Export::of_times(file, rows.into_values().collect());
    (export.bodies, export.markers, export.names_place) = (bodies, markers, names_place);
    Ok(export)
}

/// The pose of a body in a row. Systems leave the cells of a lost body empty or set them to 0.
fn pose(table: &LogTable, body: &ExportColumns, row: usize) -> Result<Option<Pose>, DataError> {
    if let Some((column, tracked)) = body.status {
        let status = table.text(column, row).trim().to_lowercase();
        if !tracked.contains(&status.as_str()) {
            return Ok(None);
        }
    }
    let Some(position) = table.numbers(&body.position, row)? else { return Ok(None) };
    let quaternion = match &body.orientation {
        OrientationCells::None => Some([1.0, 0.0, 0.0, 0.0]),
        OrientationCells::Quaternion(columns) => {
            let parts =
                table.numbers(columns, row)?.filter(|parts| parts.iter().any(|x| *x != 0.0));
            parts.map(|parts| unit(table, columns[0], row, parts)).transpose()?
        }
        OrientationCells::Matrix(columns) => {
            let parts =
                table.numbers(columns, row)?.filter(|parts| parts.iter().any(|x| *x != 0.0));
            parts.map(|parts| from_matrix(table, columns[0], row, &parts)).transpose()?
        }
    };
    let is_lost = matches!(body.orientation, OrientationCells::None) && position == [0.0; 3];
    let pose = |quaternion| Pose { position_m: position.map(|x| x * body.unit_m), quaternion };
    Ok(quaternion.filter(|_| !is_lost).map(pose))
}

fn unit(
    table: &LogTable,
    column: usize,
    row: usize,
    parts: [f64; 4],
) -> Result<[f64; 4], DataError> {
    let length = unit_length(&parts).map_err(|length| {
        let expected = format!("a unit quaternion (this row's has length {length:.4})");
        table.wrong(column, row, expected)
    })?;
    Ok(parts.map(|part| part / length))
}

/// The quaternion w, x, y, z of a rotation matrix, column by column.
fn from_matrix(
    table: &LogTable,
    column: usize,
    row: usize,
    elements: &[f64; 9],
) -> Result<[f64; 4], DataError> {
    /// Elements are written with five decimals or more.
    const TOLERANCE: f64 = 1e-2;
    let matrix = nalgebra::Matrix3::from_column_slice(elements);
    let away = (matrix.transpose() * matrix - nalgebra::Matrix3::identity()).amax();
    if away > TOLERANCE || matrix.determinant() < 0.0 {
        return Err(table.wrong(column, row, "nine elements of a rotation matrix"));
    }
    let rotation = nalgebra::Rotation3::from_matrix_eps(
        &matrix,
        f64::EPSILON,
        100,
        nalgebra::Rotation3::from_matrix_unchecked(matrix),
    );
    let turn = nalgebra::UnitQuaternion::from_rotation_matrix(&rotation);
    Ok([turn.w, turn.i, turn.j, turn.k])
}
