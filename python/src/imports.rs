//! Imports of other people's files and exports for viewers; `spinebench/_bags.py` gives them names.

use std::path::PathBuf;

use pyo3::prelude::*;
use spinebench::data::findings::ResidualRow;
use spinebench::data::import::mapped::{ClockFit, MappedImport, SourceKind, import_bag, import_text};
use spinebench::data::mcap::{Shown, to_mcap};
use spinebench::data::{Recording, tables, write_atomic};
use spinebench::specs::read_map;
use spinebench::tasks::body_lines_m;

use crate::calls::long;
use crate::errors::Fault;
use crate::model::PyModel;

/// Offset, interval, lag and explained share.
type Clock = Option<(f64, (f64, f64), f64, f64)>;

fn written(found: &MappedImport, out: &std::path::Path) -> Result<Clock, Fault> {
    found.recording.write(out)?;
    let parts = |clock: &ClockFit| {
        let [low_s, high_s] = clock.interval_95_s;
        (clock.offset_s, (low_s, high_s), clock.lag_s, clock.explained)
    };
    Ok(found.clock.as_ref().map(parts))
}

/// Imports text files by the map in a file.
#[pyfunction]
pub(crate) fn _import_csv(py: Python<'_>, files: Vec<PathBuf>, map: PathBuf, out: PathBuf) -> PyResult<Clock> {
    long(py, move |_| {
        let map = read_map(&map, SourceKind::Text(files.len()))?;
        written(&import_text(&files, &map)?, &out)
    })
}

/// Imports a bag by the map in a file.
#[pyfunction]
pub(crate) fn _import_mcap(py: Python<'_>, bag: PathBuf, map: PathBuf, out: PathBuf) -> PyResult<Clock> {
    long(py, move |_| {
        let map = read_map(&map, SourceKind::Bag)?;
        written(&import_bag(&bag, &map)?, &out)
    })
}

/// Exports a recording with the robot of a model and the residuals of a discovery.
#[pyfunction]
pub(crate) fn _export_mcap(
    py: Python<'_>,
    recording: PathBuf,
    out: PathBuf,
    model: Option<PyRef<'_, PyModel>>,
    residuals: Option<PathBuf>,
    at_rest: bool,
) -> PyResult<()> {
    let model = model.map(|model| model.clone());
    long(py, move |_| {
        let read = if at_rest { Recording::read_poses(&recording)? } else { Recording::read(&recording)? };
        let residuals = residuals.map(|file| tables::read_csv::<ResidualRow>(&file)).transpose()?.unwrap_or_default();
        let shape_m = match &model {
            Some(model) => body_lines_m(&recording, &read, &model.0, at_rest)?,
            None => Vec::new(),
        };
        let shown = Shown { recording: &read, at_rest, shape_m: &shape_m, residuals: &residuals };
        Ok(write_atomic(&out, &to_mcap(&shown))?)
    })
}
