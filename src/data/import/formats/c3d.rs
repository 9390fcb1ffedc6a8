//! C3D (c3d.org): markers over time, read by the crate `c3dio`.

use std::panic::catch_unwind;
use std::path::Path;

use c3dio::{C3d, Points};

use crate::data::DataError;
use crate::data::import::{Body, Export};
use crate::data::recording::Pose;

/// Second byte of a C3D file.
const MAGIC: u8 = 0x50;
/// Size of the header.
const HEADER_BYTES: usize = 512;

/// Reads the bytes of a file.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Export, DataError> {
    let refuse = |found: String, expected: &str| DataError::Line {
        file: path.to_owned(),
        place: "the header".to_owned(),
        found,
        expected: expected.to_owned(),
    };
    if bytes.len() < HEADER_BYTES || bytes[1] != MAGIC {
        return Err(refuse("another kind of file".to_owned(), "a C3D file"));
    }
    // The crate trusts what a damaged file says of its own sizes.
    let read = catch_unwind(|| C3d::from_bytes(bytes).map_err(|error| error.to_string()))
        .map_err(|_| refuse("a damaged file".to_owned(), "an intact C3D file"))?
        .map_err(|found| refuse(found, "an intact C3D file"))?;
    export(path, &read.points)
}

fn export(path: &Path, points: &Points) -> Result<Export, DataError> {
    let refuse = |place: &str, found: String, expected: &str| DataError::Line {
        file: path.to_owned(),
        place: place.to_owned(),
        found,
        expected: expected.to_owned(),
    };
    let unit: String = points.units.iter().collect();
    let unit_m = match unit.trim().trim_matches('\0').to_lowercase().as_str() {
        "mm" => 1e-3,
        "cm" => 1e-2,
        "m" => 1.0,
        other => return Err(refuse("POINT:UNITS", format!("`{other}`"), "`mm`, `cm` or `m`")),
    };
    let rate_hz = f64::from(points.frame_rate);
    if !(rate_hz.is_finite() && rate_hz > 0.0) {
        return Err(refuse("POINT:RATE", rate_hz.to_string(), "a frame rate in Hz, above 0"));
    }
    let frames = points.points.rows();
    if frames == 0 || points.labels.is_empty() {
        let found = format!("{frames} frames of {} markers", points.labels.len());
        return Err(refuse("the header", found, "at least one of both"));
    }
    let columns = points.points.cols();
    if columns > points.labels.len() {
        let expected = format!("one for each of the {columns} markers");
        return Err(refuse("POINT:LABELS", format!("{} names", points.labels.len()), &expected));
    }
    // Frames count from 1.
    let first = f64::from(points.first_frame.max(1)) - 1.0;
    let time_s = (0..frames).map(|frame| (first + frame as f64) / rate_hz).collect();
    let mut export = Export::of_times(path.to_owned(), time_s);
    let markers = points.labels.iter().take(columns).enumerate();
    export.markers = markers
        .map(|(column, label)| Body {
            name: label.trim().to_owned(),
            has_orientation: false,
            poses: (0..frames).map(|frame| pose(points, frame, column, unit_m)).collect(),
        })
        .collect();
    let promised = usize::from(points.last_frame.saturating_sub(points.first_frame)) + 1;
    export.promised_frames = Some(promised);
    export.names_place = "POINT:LABELS".to_owned();
    Ok(export)
}

/// The place of a marker; its residual is negative where it was lost.
fn pose(points: &Points, frame: usize, column: usize, unit_m: f64) -> Option<Pose> {
    let marker = points.points.get(frame, column)?;
    let is_lost = marker.residual < 0.0 || marker.point == [0.0; 3];
    let position_m = marker.point.map(|x| f64::from(x) * unit_m);
    let is_number = position_m.iter().all(|x| x.is_finite());
    (!is_lost && is_number).then_some(Pose { position_m, quaternion: [1.0, 0.0, 0.0, 0.0] })
}
