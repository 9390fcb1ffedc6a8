//! Model files and plant files, read and checked on their own.

use super::check::discovery::check_entries;
use super::document::error::SpecError;
use super::document::locate::PathEnd;
use super::document::merged::Document;
use super::document::path::KeyPath;
use crate::base::BadOption;
use crate::data::import::mapped::{ImportMap, SourceKind};
use crate::discovery::Options;
use crate::effects::Model;
use crate::plants::PlantSpec;
use std::path::{Path, PathBuf};

/// Reads and checks a model file.
///
/// # Errors
/// [`SpecError`] for the first invalid key or value.
pub fn read_model(file: &Path) -> Result<Model, SpecError> {
    let document = Document::read(file, &[], &[])?;
    let model = document.parse::<Model>()?;
    // A wrong unit first: other numbers are judged against it.
    let faults: Vec<SpecError> =
        model.unit_faults().iter().map(|(path, error)| refusal(&document, path, error)).collect();
    if !faults.is_empty() {
        return Err(SpecError::of_all(faults));
    }
    model.check().map_err(|(path, error)| refusal(&document, &path, &error))?;
    Ok(model)
}

/// Reads and checks a plant file: a robot as in an experiment's `plant`, whose model may be the
/// name of a model file. Names of models and recordings are relative to the folder of the plant
/// file.
///
/// # Errors
/// As [`read_model`].
pub fn read_plant(file: &Path) -> Result<PlantSpec, SpecError> {
    let document = Document::read(file, &[], &model_paths(&KeyPath::default()))?;
    let mut plant = document.parse::<PlantSpec>()?;
    plant.check().map_err(|(path, error)| refusal(&document, &path, &error))?;
    if let Some(folder) = file.parent() {
        plant.resolve_files(folder);
    }
    Ok(plant)
}

/// The files that a model, a plant or discovery options are read from: `file`, the files that it
/// extends, and the models that it names. Only `file` when it cannot be read.
pub fn files_behind(file: &Path) -> Vec<PathBuf> {
    let document = Document::read(file, &[], &model_paths(&KeyPath::default()));
    document.map_or_else(|_| vec![file.to_owned()], |document| document.files())
}

/// Where below the place of a plant the names of model files may stand.
pub(super) fn model_paths(plant: &KeyPath) -> Vec<KeyPath> {
    let below = |keys: String| keys.split('.').fold(plant.clone(), |path, key| path.key(key));
    PlantSpec::model_keys().into_iter().map(below).collect()
}

/// Reads and checks discovery options.
///
/// # Errors
/// As [`read_model`].
pub fn read_options(file: &Path) -> Result<Options, SpecError> {
    let document = Document::read(file, &[], &[])?;
    let options = document.parse::<Options>()?;
    check_entries(&document, &options, &KeyPath::default())?;
    options.check().map_err(|error| refusal(&document, "", &error))?;
    Ok(options)
}

/// Reads and checks the map of an import from such a source.
///
/// # Errors
/// As [`read_model`].
pub fn read_map(file: &Path, source: SourceKind) -> Result<ImportMap, SpecError> {
    let document = Document::read(file, &[], &[])?;
    let map = document.parse::<ImportMap>()?;
    map.check(source).map_err(|(path, error)| refusal(&document, &path, &error))?;
    Ok(map)
}

/// The error for a field below `path` that is out of range.
fn refusal(document: &Document, path: &str, error: &BadOption) -> SpecError {
    let parent = KeyPath::parse(path).unwrap_or_default();
    document.refuse(&parent.key(error.key), PathEnd::Value, error.found.clone(), error.expected)
}
