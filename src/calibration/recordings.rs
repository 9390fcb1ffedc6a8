//! What a model is calibrated on: one recording of a robot or several, each under loads of its own.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::ops::Range;
use std::path::Path;

use crate::data::Recording;
use crate::data::recording::RecordingMismatch;

/// Recordings of one robot, one after the other.
#[derive(Clone, Debug)]
pub struct Recordings {
    pub(super) joined: Recording,
    /// Name and rows of each.
    pub(super) each: Vec<(String, Range<usize>)>,
}

impl Recordings {
    /// The recordings under the names of their files: without folder and extension, or whole where
    /// two are alike.
    ///
    /// # Errors
    /// [`RecordingMismatch`] as [`Recording::joined`].
    pub fn new<P: AsRef<Path>>(
        files: &[P],
        recordings: &[Recording],
    ) -> Result<Recordings, RecordingMismatch> {
        let stem = |file: &P| file.as_ref().file_stem().map(ToOwned::to_owned).unwrap_or_default();
        let stems: BTreeSet<OsString> = files.iter().map(stem).collect();
        let name = |file: &P| {
            if stems.len() == files.len() {
                return stem(file).to_string_lossy().into_owned();
            }
            file.as_ref().display().to_string()
        };
        let mut end = 0;
        let rows = recordings.iter().map(|recording| {
            let start = end;
            end += recording.len();
            start..end
        });
        let each = files.iter().map(name).zip(rows).collect();
        Ok(Recordings { joined: Recording::joined(recordings)?, each })
    }

    /// Place of the recording that a row belongs to.
    pub(super) fn of_row(&self, row: usize) -> usize {
        self.each.iter().position(|(_, rows)| rows.contains(&row)).unwrap_or_default()
    }
}

impl From<Recording> for Recordings {
    fn from(recording: Recording) -> Recordings {
        let rows = 0..recording.len();
        Recordings { joined: recording, each: vec![("recording".to_owned(), rows)] }
    }
}
