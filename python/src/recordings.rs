//! Recordings in and out: files, or the columns of a frame.

use std::path::PathBuf;

use pyo3::prelude::*;
use spinebench::data::{Cells, Recording, RecordingColumns, RecordingSource};

use crate::errors::Fault;

/// The cells of a column as Python has them.
#[derive(FromPyObject, IntoPyObject)]
pub(crate) enum PyCells {
    Flags(Vec<bool>),
    Integers(Vec<i64>),
    Numbers(Vec<f64>),
    Text(Vec<String>),
}

/// A column: its name and cells.
pub(crate) type PyColumn = (String, PyCells);

/// A recording as it is given: a file, or what messages call it with its columns.
#[derive(FromPyObject)]
pub(crate) enum PyRecording {
    File(PathBuf),
    Frame((String, Vec<PyColumn>)),
}

/// A recording to be read.
pub(crate) enum NamedRecording {
    File(PathBuf),
    Columns(RecordingColumns),
}

impl PyRecording {
    /// Checks the names of a frame's columns.
    pub(crate) fn named(self) -> Result<NamedRecording, Fault> {
        let (name, columns) = match self {
            PyRecording::File(file) => return Ok(NamedRecording::File(file)),
            PyRecording::Frame(frame) => frame,
        };
        let cells = |cells| match cells {
            PyCells::Flags(cells) => Cells::Flags(cells),
            PyCells::Integers(cells) => Cells::Integers(cells),
            PyCells::Numbers(cells) => Cells::Numbers(cells),
            PyCells::Text(cells) => Cells::Text(cells),
        };
        let columns = columns.into_iter().map(|(column, each)| (column, cells(each))).collect();
        Ok(NamedRecording::Columns(RecordingColumns::new(&name, columns)?))
    }
}

impl NamedRecording {
    pub(crate) fn source(&self) -> RecordingSource<'_> {
        match self {
            NamedRecording::File(file) => RecordingSource::from(file),
            NamedRecording::Columns(columns) => RecordingSource::from(columns),
        }
    }
}

/// The columns of a recording.
pub(crate) fn columns(recording: &Recording) -> Result<Vec<PyColumn>, Fault> {
    let cells = |cells| match cells {
        // Numbers of trials: pandas has signed ones.
        Cells::Unsigned(cells) => PyCells::Integers(cells.into_iter().map(|x| x as i64).collect()),
        Cells::Integers(cells) => PyCells::Integers(cells),
        Cells::Numbers(cells) => PyCells::Numbers(cells),
        Cells::Flags(cells) => PyCells::Flags(cells),
        Cells::Text(cells) => PyCells::Text(cells),
    };
    let columns = recording.columns().map_err(Fault::Run)?;
    Ok(columns.into_iter().map(|(name, each)| (name, cells(each))).collect())
}
