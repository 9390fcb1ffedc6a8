//! Answers of a discovery for Python, and the folder that they are saved in.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use spinebench::data::{Recording, tables};
use spinebench::discovery::Discovery;
use spinebench::report::discovery::write_folder;
use spinebench::runner::{AskedDiscovery, discovery_files};

use crate::calculations::json;
use crate::calls::detached;
use crate::errors::Fault;
use crate::model::PyModel;

/// An answer: the extended model, the findings as JSON, residuals and residual map as CSV, and the
/// files that `discover` writes.
pub(crate) type WrittenDiscovery = (PyModel, String, Vec<u8>, Vec<u8>, Vec<(String, Vec<u8>)>);

/// The answer about `model` and what was measured, poses at rest or motion; `limitations` follow from how the recordings were given.
pub(crate) fn written(
    answer: &Discovery,
    model: &PyModel,
    (measured, at_rest): (&Recording, bool),
    limitations: Vec<String>,
) -> Result<WrittenDiscovery, Fault> {
    let mut answer = answer.clone();
    let starts = model.model.tracking.starts.told().map(str::to_owned);
    let name = model.file.as_ref().map_or(Path::new("model"), |file| &file.name);
    let unusual = model.model.unusual_number(name);
    answer.findings.limitations.extend(limitations.into_iter().chain(starts).chain(unusual));
    let text = match &model.file {
        Some(file) => file.text.clone(),
        None => model.yaml()?,
    };
    let asked = AskedDiscovery { model: &model.model, model_text: &text, measured, at_rest };
    let files = discovery_files(&answer, &asked).map_err(|error| Fault::Run(error.to_string()))?;
    let residuals = tables::to_csv(Path::new("residuals.csv"), &answer.residuals)?;
    let places = tables::to_csv(Path::new("disagreement.csv"), &answer.places)?;
    let findings = json(&answer.findings)?;
    Ok((PyModel::from(answer.model), findings, residuals, places, files))
}

/// Writes the files of an answer into a folder.
#[pyfunction]
pub(crate) fn _save_discovery(
    py: Python<'_>,
    out: PathBuf,
    files: Vec<(String, PyBackedBytes)>,
) -> PyResult<()> {
    let files: Vec<(String, Vec<u8>)> =
        files.into_iter().map(|(name, bytes)| (name, bytes.to_vec())).collect();
    detached(py, || Ok(write_folder(&out, &files)?))
}
