//! The first line of an export: alternating keys and values.

use std::path::Path;

use super::ExportLine;
use crate::data::DataError;
use crate::data::csv::line_error;
use crate::data::error::shown;

/// Representation of orientations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rotation {
    /// Unit quaternions.
    Quaternion,
    /// Intrinsic Euler angles about x, y and z in degrees, called XYZ by Motive.
    Xyz,
}

impl Rotation {
    /// Column names, in the order of the numbers in this project.
    pub(crate) fn parts(self) -> &'static [&'static str] {
        match self {
            Rotation::Quaternion => &["W", "X", "Y", "Z"],
            Rotation::Xyz => &["X", "Y", "Z"],
        }
    }
}

/// Contents of the first line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Meta {
    /// Metres in the export's unit of length.
    pub(crate) unit_m: f64,
    pub(crate) rotation: Rotation,
    /// Number of frames that should follow.
    pub(crate) frames: Option<usize>,
}

const UNITS: [(&str, f64); 5] = [
    ("meters", 1.0),
    ("centimeters", 1e-2),
    ("millimeters", 1e-3),
    ("inches", 0.0254),
    ("feet", 0.3048),
];

const EXPECTED_FIRST_LINE: &str = "`Format Version,1.2…`: an export by Motive with its header";

/// Reads the first line.
pub(crate) fn meta(path: &Path, line: &ExportLine) -> Result<Meta, DataError> {
    let first = line.cell(0);
    if first.starts_with("Format Version;") {
        let found = "cells between semicolons (saved again by a spreadsheet?)";
        return Err(line_error(
            path,
            line.number,
            found,
            "Motive's own file: commas between cells, points in numbers",
        ));
    }
    if !first.eq_ignore_ascii_case("Format Version") {
        return Err(line_error(path, line.number, shown(&clipped(first)), EXPECTED_FIRST_LINE));
    }
    let version = line.cell(1);
    // Later minor versions have so far only added keys and rows, which are found by name.
    if !version.starts_with("1.") {
        return Err(bad_value(path, "Format Version", version, "1.2x".to_owned()));
    }
    let space = value(line, "Coordinate Space");
    if let Some(space) = space.filter(|space| !space.eq_ignore_ascii_case("Global")) {
        let expected = "`Global`: poses in one frame for all bodies".to_owned();
        return Err(bad_value(path, "Coordinate Space", space, expected));
    }
    let frames = value(line, "Total Exported Frames").and_then(|frames| frames.parse().ok());
    Ok(Meta { unit_m: unit(path, line)?, rotation: rotation(path, line)?, frames })
}

fn unit(path: &Path, line: &ExportLine) -> Result<f64, DataError> {
    const KEY: &str = "Length Units";
    let name = value(line, KEY).unwrap_or_default();
    let unit = UNITS.iter().find(|(unit_name, _)| name.eq_ignore_ascii_case(unit_name));
    let expected = || "`Meters`, `Centimeters`, `Millimeters`, `Inches` or `Feet`".to_owned();
    unit.map(|(_, unit_m)| *unit_m).ok_or_else(|| bad_value(path, KEY, name, expected()))
}

fn rotation(path: &Path, line: &ExportLine) -> Result<Rotation, DataError> {
    const KEY: &str = "Rotation Type";
    match value(line, KEY).unwrap_or_default() {
        name if name.eq_ignore_ascii_case("Quaternion") => Ok(Rotation::Quaternion),
        "XYZ" => Ok(Rotation::Xyz),
        name => Err(bad_value(
            path,
            KEY,
            name,
            "`Quaternion` (or the Euler angles `XYZ`): change the export setting".to_owned(),
        )),
    }
}

/// The cell after a key. Keys are searched one by one, not in pairs: a name with an unquoted comma
/// shifts the pairs.
fn value<'a>(line: &'a ExportLine, key: &str) -> Option<&'a str> {
    let place = (0..line.cells.len()).find(|&index| line.cell(index).eq_ignore_ascii_case(key))?;
    Some(line.cell(place + 1))
}

fn bad_value(path: &Path, key: &str, found: &str, expected: String) -> DataError {
    let (place, column, found) = ("line 1".to_owned(), key.to_owned(), shown(&clipped(found)));
    DataError::Cell { file: path.to_owned(), place, column, found, expected }
}

/// A text shortened for messages.
fn clipped(text: &str) -> String {
    const MAX_CHARACTERS: usize = 40;
    if text.chars().count() <= MAX_CHARACTERS {
        text.to_owned()
    } else {
        text.chars().take(MAX_CHARACTERS).chain(['…']).collect()
    }
}
