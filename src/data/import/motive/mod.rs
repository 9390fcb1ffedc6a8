//! The CSV export of OptiTrack's Motive (format versions 1.2x): rigid bodies over time. Columns are found by their
//! header, not by position; other assets (markers, bones) are skipped.

mod header;
mod meta;
mod read;

use std::path::{Path, PathBuf};

use crate::data::recording::Pose;
use crate::data::{DataError, file};

/// A rigid body over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Its name in Motive.
    pub name: String,
    /// Pose of its pivot for each frame, in the export's frame; `None` where the body was not tracked.
    pub poses: Vec<Option<Pose>>,
}

/// The rigid bodies of an export.
#[derive(Clone, Debug, PartialEq)]
pub struct Export {
    /// The file.
    pub file: PathBuf,
    /// Time of each frame in the export, seconds, increasing.
    pub time_s: Vec<f64>,
    /// In the order of the file.
    pub bodies: Vec<Body>,
    /// Number of frames according to the header.
    pub promised_frames: Option<usize>,
    /// Line of the names.
    names_line: usize,
}

impl Export {
    /// Reads a file.
    ///
    /// # Errors
    /// [`DataError`] names file, line, column, what was found and what was expected.
    pub fn read(path: &Path) -> Result<Export, DataError> {
        Export::parse(path, &file::read(path)?)
    }

    /// Reads the bytes of a file; `path` is for messages.
    ///
    /// # Errors
    /// As [`Export::read`].
    pub fn parse(path: &Path, bytes: &[u8]) -> Result<Export, DataError> {
        read::export(path, bytes)
    }

    /// The body with exactly this name.
    ///
    /// # Errors
    /// [`DataError::Line`] lists all bodies when none or several have it.
    pub fn body(&self, name: &str) -> Result<&Body, DataError> {
        let named: Vec<&Body> = self.bodies.iter().filter(|body| body.name == name).collect();
        match named[..] {
            [body] => Ok(body),
            _ => Err(self.unclear(format!("one called `{name}`"))),
        }
    }

    /// The body called `word`, or else the only one whose name begins so, ignoring case.
    ///
    /// # Errors
    /// As [`Export::body`].
    pub fn body_like(&self, word: &str) -> Result<&Body, DataError> {
        if self.bodies.iter().any(|body| body.name == word) {
            return self.body(word);
        }
        let begins = |name: &str| name.to_lowercase().starts_with(&word.to_lowercase());
        let alike: Vec<&Body> = self.bodies.iter().filter(|body| begins(&body.name)).collect();
        match alike[..] {
            [body] => Ok(body),
            _ => Err(self.unclear(format!("one called `{word}`, or a single one whose name begins so"))),
        }
    }

    fn unclear(&self, expected: String) -> DataError {
        let names: Vec<String> = self.bodies.iter().map(|body| format!("`{}`", body.name)).collect();
        DataError::Line {
            file: self.file.clone(),
            place: format!("line {}", self.names_line),
            found: format!("the rigid bodies {}", names.join(", ")),
            expected,
        }
    }
}

/// A line with its number in the file, from 1.
struct ExportLine<'a> {
    number: usize,
    cells: Vec<std::borrow::Cow<'a, str>>,
}

impl ExportLine<'_> {
    /// The cell, without spaces around it; empty beyond the end.
    fn cell(&self, index: usize) -> &str {
        self.cells.get(index).map_or("", |cell| cell.trim())
    }

    /// Number of cells up to the last that holds something.
    fn filled(&self) -> usize {
        self.cells.iter().rposition(|cell| !cell.trim().is_empty()).map_or(0, |last| last + 1)
    }
}

/// The error for a line.
fn wrong_line(path: &Path, number: usize, found: impl Into<String>, expected: impl Into<String>) -> DataError {
    let place = format!("line {number}");
    DataError::Line { file: path.to_owned(), place, found: found.into(), expected: expected.into() }
}
