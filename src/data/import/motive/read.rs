//! Parsing of an export.

use std::borrow::Cow;
use std::path::Path;

use super::ExportLine;
use super::header;
use super::header::{BodyColumns, ExportLayout};
use super::meta;
use super::meta::{Meta, Rotation};
use crate::data::csv::line_error;
use crate::data::error::shown;
use crate::data::import::{Body, Export};
use crate::data::recording::{Pose, unit_length};
use crate::data::{DataError, csv};

/// Reads a whole export.
pub(crate) fn export(path: &Path, bytes: &[u8]) -> Result<Export, DataError> {
    let text = csv::decode(path, bytes)?;
    let ends_with_line_end = text.ends_with(['\n', '\r']);
    let text = text.trim_end_matches(['\n', '\r']);
    let mut lines = text.lines().enumerate().map(|(index, line)| split(path, index + 1, line));
    let Some(first) = lines.next() else {
        let expected = "an export by Motive";
        return Err(DataError::Empty { file: path.to_owned(), found: "nothing", expected });
    };
    let meta = meta::meta(path, &first?)?;
    let layout = layout(path, &mut lines, &meta)?;
    let mut frames = Frames { path, meta, layout, time_s: Vec::new(), poses: Vec::new() };
    let mut short_line = None;
    for line in lines {
        let line = line?;
        short_line =
            (line.cells.len() < frames.layout.width).then_some((line.number, line.cells.len()));
        frames.push(&line)?;
    }
    // Spreadsheets drop trailing empty cells; a last line without a line end was cut off.
    if let Some((number, cells)) = short_line.filter(|_| !ends_with_line_end) {
        let expected = format!("{} as in the header: the file was cut off", frames.layout.width);
        return Err(line_error(path, number, format!("{cells} cells"), expected));
    }
    frames.finish()
}

/// The cells of a line, without the quotation marks around them.
fn split<'a>(path: &Path, number: usize, line: &'a str) -> Result<ExportLine<'a>, DataError> {
    let cells = csv::split(line).ok_or_else(|| csv::unclosed(path, number))?;
    Ok(ExportLine { number, cells: cells.into_iter().map(unquoted).collect() })
}

fn unquoted(cell: &str) -> Cow<'_, str> {
    match cell.trim().strip_prefix('"').and_then(|rest| rest.strip_suffix('"')) {
        None => Cow::Borrowed(cell),
        Some(inner) if inner.contains("\"\"") => Cow::Owned(inner.replace("\"\"", "\"")),
        Some(inner) => Cow::Borrowed(inner),
    }
}

/// Consumes the header rows.
fn layout<'a>(
    path: &Path,
    lines: &mut impl Iterator<Item = Result<ExportLine<'a>, DataError>>,
    meta: &Meta,
) -> Result<ExportLayout, DataError> {
    const EXPECTED_LAST_ROW: &str = "the row `Frame,Time (Seconds),X,Y,Z,…` before the frames";
    let mut rows: Vec<ExportLine> = Vec::new();
    let mut last_line = 1;
    for line in lines {
        let line = line?;
        last_line = line.number;
        if header::is_last(&line) {
            return header::layout(path, &rows, &line, meta.rotation);
        }
        if line.cell(0).parse::<f64>().is_ok() {
            return Err(line_error(path, line.number, "a row of numbers", EXPECTED_LAST_ROW));
        }
        if line.filled() > 0 {
            rows.push(line);
        }
    }
    Err(line_error(path, last_line, "the end of the file", EXPECTED_LAST_ROW))
}

/// The frames read so far.
struct Frames<'a> {
    path: &'a Path,
    meta: Meta,
    layout: ExportLayout,
    time_s: Vec<f64>,
    /// Poses frame by frame, all bodies of a frame and then all markers in sequence.
    poses: Vec<Option<Pose>>,
}

impl Frames<'_> {
    fn push(&mut self, line: &ExportLine) -> Result<(), DataError> {
        if line.filled() > self.layout.width {
            let found = format!("{} cells", line.filled());
            let expected = format!(
                "{} as in the header (decimal commas split numbers in two)",
                self.layout.width
            );
            return Err(line_error(self.path, line.number, found, expected));
        }
        let time_s = self.time(line)?;
        self.time_s.push(time_s);
        for columns in self.layout.bodies.iter().chain(&self.layout.markers) {
            self.poses.push(self.pose(line, columns)?);
        }
        Ok(())
    }

    fn time(&self, line: &ExportLine) -> Result<f64, DataError> {
        const NAME: &str = "Time (Seconds)";
        let cell = line.cell(self.layout.time);
        let Some(time_s) = number(cell).flatten() else {
            return Err(self.bad(
                line,
                NAME.to_owned(),
                cell,
                "seconds, a number with a decimal point".to_owned(),
            ));
        };
        if let Some(before) = self.time_s.last().filter(|before| time_s <= **before) {
            let expected = format!("more than {before}, the time of the previous frame");
            return Err(self.bad(line, NAME.to_owned(), cell, expected));
        }
        Ok(time_s)
    }

    /// The pose of a body in a frame, unturned for a marker without orientation. Motive leaves the
    /// cells of an untracked body empty or sets all of them to 0.
    fn pose(&self, line: &ExportLine, columns: &BodyColumns) -> Result<Option<Pose>, DataError> {
        let mut position_m = [0.0; 3];
        let mut rotation = [0.0; 4];
        let mut tracked = true;
        let position = columns.position.iter().zip(["Position X", "Position Y", "Position Z"]);
        for (value, (&index, what)) in position_m.iter_mut().zip(position) {
            match self.number(line, columns, index, what)? {
                Some(number) => *value = number * self.meta.unit_m,
                None => tracked = false,
            }
        }
        let parts = self.meta.rotation.parts();
        for (value, (&index, part)) in rotation.iter_mut().zip(columns.rotation.iter().zip(parts)) {
            match self.number(line, columns, index, &format!("Rotation {part}"))? {
                Some(number) => *value = number,
                None => tracked = false,
            }
        }
        let is_point = columns.rotation.is_empty();
        let is_zero = position_m.iter().chain(&rotation).all(|&value| value == 0.0);
        if !tracked || is_zero && (is_point || parts.len() == rotation.len()) {
            return Ok(None);
        }
        let quaternion = match self.meta.rotation {
            _ if is_point => [1.0, 0.0, 0.0, 0.0],
            Rotation::Quaternion => self.unit(line, columns, rotation)?,
            Rotation::Xyz => from_xyz([rotation[0], rotation[1], rotation[2]]),
        };
        Ok(Some(Pose { position_m, quaternion }))
    }

    fn number(
        &self,
        line: &ExportLine,
        columns: &BodyColumns,
        index: usize,
        what: &str,
    ) -> Result<Option<f64>, DataError> {
        let cell = line.cell(index);
        number(cell).ok_or_else(|| {
            let column = format!("{} {what}", columns.name);
            self.bad(
                line,
                column,
                cell,
                "a number with a decimal point, or an empty cell".to_owned(),
            )
        })
    }

    fn unit(
        &self,
        line: &ExportLine,
        columns: &BodyColumns,
        rotation: [f64; 4],
    ) -> Result<[f64; 4], DataError> {
        let length = unit_length(&rotation).map_err(|length| {
            let expected = "a unit quaternion".to_owned();
            let found = format!("{} of length {length:.4}", shown(line.cell(columns.rotation[0])));
            let column = format!("{} Rotation W", columns.name);
            let place = format!("line {}", line.number);
            DataError::Cell { file: self.path.to_owned(), place, column, found, expected }
        })?;
        Ok(rotation.map(|part| part / length))
    }

    fn bad(&self, line: &ExportLine, column: String, cell: &str, expected: String) -> DataError {
        let place = format!("line {}", line.number);
        DataError::Cell { file: self.path.to_owned(), place, column, found: shown(cell), expected }
    }

    fn finish(self) -> Result<Export, DataError> {
        if self.time_s.is_empty() {
            let (found, expected) = ("a header and no frames", "at least one frame");
            return Err(DataError::Empty { file: self.path.to_owned(), found, expected });
        }
        let (rigid, count) =
            (self.layout.bodies.len(), self.layout.bodies.len() + self.layout.markers.len());
        let all = self.layout.bodies.into_iter().chain(self.layout.markers).enumerate();
        let mut bodies: Vec<Body> = all
            .map(|(index, columns)| {
                let poses = self.poses.iter().skip(index).step_by(count).copied().collect();
                Body { name: columns.name, has_orientation: !columns.rotation.is_empty(), poses }
            })
            .collect();
        let markers = bodies.split_off(rigid);
        Ok(Export {
            file: self.path.to_owned(),
            time_s: self.time_s,
            bodies,
            markers,
            promised_frames: self.meta.frames,
            unread_orientations: Vec::new(),
            names_place: format!("line {}", self.layout.names_line),
        })
    }
}

/// The number in a cell: `Some(None)` for an empty cell, `None` for other text.
fn number(cell: &str) -> Option<Option<f64>> {
    if cell.is_empty() || cell.eq_ignore_ascii_case("nan") {
        return Some(None);
    }
    cell.parse().ok().filter(|number: &f64| number.is_finite()).map(Some)
}

/// Quaternion w, x, y, z of intrinsic Euler angles about x, y and z.
fn from_xyz(angles_deg: [f64; 3]) -> [f64; 4] {
    let [(sx, cx), (sy, cy), (sz, cz)] =
        angles_deg.map(|angle_deg| (0.5 * angle_deg.to_radians()).sin_cos());
    [
        cx * cy * cz - sx * sy * sz,
        sx * cy * cz + cx * sy * sz,
        cx * sy * cz - sx * cy * sz,
        cx * cy * sz + sx * sy * cz,
    ]
}
