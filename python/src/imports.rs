//! Imports of other people's files and exports for viewers; `spinebench/_bags.py` gives them names.

use std::path::PathBuf;

use pyo3::prelude::*;
use spinebench::data::findings::ResidualRow;
use spinebench::data::import::mapped::{
    ClockFit, ImportMap, LogFiles, MappedImport, SourceKind, TrialClock, import_bag, import_text,
};
use spinebench::data::mcap::{Shown, to_mcap};
use spinebench::data::{Recording, tables, write_atomic};
use spinebench::specs::read_map;
use spinebench::tasks::scene_of_recording;

use crate::calls::long;
use crate::errors::Fault;
use crate::model::{GivenModel, read_text};
use crate::recordings::{PyColumn, PyRecording, columns};

/// Trial with files of its own, offset, interval, lag and explained share.
type Clock = (Option<u64>, f64, (f64, f64), f64, f64);

/// The columns of the recording, the clocks, the files that were passed over, and notes.
type ToldImport = (Vec<PyColumn>, Vec<Clock>, Vec<PathBuf>, Vec<String>);

fn told(found: MappedImport) -> Result<ToldImport, Fault> {
    let parts = |TrialClock { trial, fit }: &TrialClock| {
        let ClockFit { offset_s, interval_95_s: [low_s, high_s], lag_s, explained, .. } = *fit;
        (*trial, offset_s, (low_s, high_s), lag_s, explained)
    };
    let (columns, notes) = (columns(&found.recording)?, found.notes());
    Ok((columns, found.clocks.iter().map(parts).collect(), found.passed_over, notes))
}

/// A map as it is given: a file, or what messages call it with its text.
#[derive(FromPyObject)]
pub(crate) enum PyMap {
    File(PathBuf),
    Text((String, String)),
}

impl PyMap {
    fn read(&self, source: SourceKind) -> Result<ImportMap, Fault> {
        match self {
            PyMap::File(file) => Ok(read_map(file, source)?),
            PyMap::Text((name, text)) => read_text(name, text, |file| Ok(read_map(file, source)?)),
        }
    }
}

/// Imports text files by a map.
#[pyfunction]
pub(crate) fn _import_csv(py: Python<'_>, files: Vec<PathBuf>, map: PyMap) -> PyResult<ToldImport> {
    long(py, move |_| {
        let logs = LogFiles::find(&files)?;
        let map = map.read(SourceKind::from(&logs))?;
        told(import_text(&logs.files, &map)?)
    })
}

/// Imports a bag by a map.
#[pyfunction]
pub(crate) fn _import_mcap(py: Python<'_>, bag: PathBuf, map: PyMap) -> PyResult<ToldImport> {
    long(py, move |_| {
        let map = map.read(SourceKind::Bag)?;
        told(import_bag(&bag, &map)?)
    })
}

/// Exports a recording with the robot of a model and the residuals of a discovery.
#[pyfunction]
pub(crate) fn _export_mcap(
    py: Python<'_>,
    recording: PyRecording,
    out: PathBuf,
    model: Option<GivenModel>,
    residuals: Option<PyRecording>,
    at_rest: bool,
) -> PyResult<()> {
    long(py, move |stop| {
        let recording = recording.named()?;
        let source = recording.source();
        let read = if at_rest { Recording::read_poses(source)? } else { Recording::read(source)? };
        let residuals = residuals.map(PyRecording::named).transpose()?;
        let residuals = residuals
            .map(|table| tables::read_rows::<ResidualRow>(table.source()))
            .transpose()?
            .unwrap_or_default();
        let scene = |GivenModel(given): &GivenModel| {
            let name = source.name();
            stop.within(|| scene_of_recording("robot", name, &read, &given.model, at_rest))
        };
        let robot = model.as_ref().map(scene).transpose()?;
        let shown =
            Shown { recording: &read, at_rest, robot: robot.as_ref(), residuals: &residuals };
        let bytes = to_mcap(&shown);
        stop.check()?;
        Ok(write_atomic(&out, &bytes)?)
    })
}
