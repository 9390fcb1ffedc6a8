//! Formats of motion capture systems' exports: one file and one line each.

mod c3d;
mod frames;
mod ndi;
mod qualisys;
mod vicon;

use std::path::Path;

use super::{Axes, Export, motive};
use crate::data::{DataError, file};

/// A format of an export.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExportFormat {
    /// CSV of OptiTrack Motive, format versions 1.2x.
    Motive,
    /// CSV of Vicon Nexus and Tracker.
    Vicon,
    /// TSV of Qualisys Track Manager.
    Qualisys,
    /// CSV of NDI's tools for Aurora, Polaris and Vega.
    Ndi,
    /// C3D (c3d.org), as most systems write it: markers.
    C3d,
}

impl ExportFormat {
    /// Reads a file. `rate_hz`: frames a second, for a format that counts frames and does not tell
    /// their rate; others refuse it.
    ///
    /// # Errors
    /// [`DataError`] names file, line, column, what was found and what was expected.
    pub fn read(self, path: &Path, rate_hz: Option<f64>) -> Result<Export, DataError> {
        self.parse(path, &file::read(path)?, rate_hz)
    }

    /// Reads the bytes of a file; `path` is for messages.
    ///
    /// # Errors
    /// As [`ExportFormat::read`].
    pub fn parse(
        self,
        path: &Path,
        bytes: &[u8],
        rate_hz: Option<f64>,
    ) -> Result<Export, DataError> {
        if let Some(rate_hz) = rate_hz.filter(|_| self != ExportFormat::Ndi) {
            return Err(DataError::Line {
                file: path.to_owned(),
                place: "all frames".to_owned(),
                found: format!("a rate of {rate_hz} Hz in addition to that of the file"),
                expected: "no rate: the file contains it".to_owned(),
            });
        }
        match self {
            ExportFormat::Motive => motive::parse(path, bytes),
            ExportFormat::Vicon => vicon::parse(path, bytes),
            ExportFormat::Qualisys => qualisys::parse(path, bytes),
            ExportFormat::Ndi => ndi::parse(path, bytes, rate_hz),
            ExportFormat::C3d => c3d::parse(path, bytes),
        }
    }

    /// The axes of a robot along z with x up in those of the system, where these are known: only
    /// Motive's y is up by default; elsewhere the export's own axes stand for the robot's.
    pub fn usual_axes(self) -> &'static str {
        if self == ExportFormat::Motive { Axes::Y_UP } else { Axes::SAME }
    }
}
