//! Answers of a discovery for Python, and the folder that they are saved in.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use spinebench::data::{Recording, tables};
use spinebench::discovery::Discovery;
use spinebench::effects::CATALOGUE;
use spinebench::report::discovery::{DiscoveryReport, EffectText, folder_files, write_folder};
use spinebench::specs::{extended_text, model_text};

use crate::calculations::json;
use crate::calls::detached;
use crate::errors::Fault;
use crate::model::PyModel;

/// An answer: the extended model, the findings as JSON, residuals and residual map as CSV, and the
/// files that `discover` writes.
pub(crate) type WrittenDiscovery = (PyModel, String, Vec<u8>, Vec<u8>, Vec<(String, Vec<u8>)>);

/// The answer about `model`; `limitations` follow from how the recordings were given.
pub(crate) fn written(
    answer: &Discovery,
    model: &PyModel,
    limitations: Vec<String>,
) -> Result<WrittenDiscovery, Fault> {
    let mut answer = answer.clone();
    let starts = model.model.tracking.starts.told().map(str::to_owned);
    let name = model.file.as_ref().map_or(Path::new("model"), |file| &file.name);
    let unusual = model.model.unusual_number(name);
    answer.findings.limitations.extend(limitations.into_iter().chain(starts).chain(unusual));
    let files = files(&answer, model)?;
    let residuals = tables::to_csv(Path::new("residuals.csv"), &answer.residuals)?;
    let places = tables::to_csv(Path::new("disagreement.csv"), &answer.places)?;
    let findings = json(&answer.findings)?;
    Ok((PyModel::from(answer.model), findings, residuals, places, files))
}

/// What `spinebench discover --out` writes of this answer.
fn files(answer: &Discovery, model: &PyModel) -> Result<Vec<(String, Vec<u8>)>, Fault> {
    let added = answer.model.effects.len() - model.model.effects.len();
    let before = model.yaml()?;
    let text = model.file.as_ref().map_or(&before, |file| &file.text);
    let (model_yaml, after) = if added == 0 {
        (text.clone(), before.clone())
    } else {
        let failed = |error: &dyn std::error::Error| Fault::Run(error.to_string());
        let extended = extended_text(text, &answer.model, added);
        let after = model_text(&answer.model).map_err(|error| failed(&error))?;
        (extended.map_err(|error| failed(&error))?, after)
    };
    let effects: Vec<EffectText> = CATALOGUE
        .iter()
        .map(|card| EffectText {
            name: card.name.to_owned(),
            missing: card.missing.to_owned(),
            equation: card.equation.to_owned(),
            source: card.source.to_owned(),
        })
        .collect();
    let report = DiscoveryReport {
        findings: &answer.findings,
        residuals: &answer.residuals,
        places: &answer.places,
        calibrated: answer.calibrated,
        effects: &effects,
        model_before: &before,
        model_after: &after,
    };
    let next = answer.next_experiments.iter();
    let commands: Vec<(&str, &Recording)> =
        next.map(|next| (next.proposal.file.as_str(), &next.commands)).collect();
    folder_files(&report, &commands, model_yaml.into_bytes())
        .map_err(|error| Fault::Run(error.to_string()))
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
