//! Recordings in and out: files, or the columns of a frame.

use std::path::PathBuf;

use numpy::{Element, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use spinebench::data::{Cells, Recording, RecordingColumns, RecordingSource};

use crate::errors::Fault;

/// The cells of a column as Python has them: an array, or a list of texts.
pub(crate) enum PyCells {
    Flags(Vec<bool>),
    Integers(Vec<i64>),
    Numbers(Vec<f64>),
    Text(Vec<String>),
}

/// The numbers of an array.
fn of_array<T: Element + Copy>(cells: &Bound<'_, PyAny>) -> Option<Vec<T>> {
    let array = cells.cast::<PyArray1<T>>().ok()?;
    Some(array.readonly().as_array().iter().copied().collect())
}

impl FromPyObject<'_, '_> for PyCells {
    type Error = PyErr;

    fn extract(cells: Borrowed<'_, '_, PyAny>) -> PyResult<PyCells> {
        if let Some(numbers) = of_array(&cells) {
            return Ok(PyCells::Numbers(numbers));
        }
        if let Some(integers) = of_array(&cells) {
            return Ok(PyCells::Integers(integers));
        }
        if let Some(flags) = of_array(&cells) {
            return Ok(PyCells::Flags(flags));
        }
        cells.extract().map(PyCells::Text)
    }
}

impl<'py> IntoPyObject<'py> for PyCells {
    type Target = PyAny;
    type Output = Bound<'py, PyAny>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(match self {
            PyCells::Flags(cells) => PyArray1::from_vec(py, cells).into_any(),
            PyCells::Integers(cells) => PyArray1::from_vec(py, cells).into_any(),
            PyCells::Numbers(cells) => PyArray1::from_vec(py, cells).into_any(),
            PyCells::Text(cells) => cells.into_pyobject(py)?,
        })
    }
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
