//! Model files and plant files, read and checked on their own.

use super::document::Document;
use super::error::SpecError;
use super::locate::End;
use super::path::KeyPath;
use super::plant::PlantSpec;
use crate::base::BadOption;
use crate::effects::Model;
use std::path::Path;

/// Reads and checks a model file.
///
/// # Errors
/// [`SpecError`] for the first thing that is wrong.
pub fn read_model(file: &Path) -> Result<Model, SpecError> {
    let document = Document::read(file, &[], &[])?;
    let model = document.parse::<Model>()?;
    model.check().map_err(|(path, error)| refusal(&document, &path, &error))?;
    Ok(model)
}

/// Reads and checks a plant file: a robot as in an experiment's `plant`, whose model may be the name of a model file.
///
/// # Errors
/// As [`read_model`].
pub fn read_plant(file: &Path) -> Result<PlantSpec, SpecError> {
    let include = KeyPath::default().key("simulated").key("model");
    let document = Document::read(file, &[], &[include])?;
    let plant = document.parse::<PlantSpec>()?;
    plant.check().map_err(|(path, error)| refusal(&document, &path, &error))?;
    Ok(plant)
}

/// The text of a model file, effects as `- name: {…}`.
///
/// # Errors
/// When a number cannot be written as YAML.
pub fn model_text(model: &Model) -> Result<String, serde_yaml::Error> {
    let mut text = Vec::new();
    let mut serializer = serde_yaml::Serializer::new(&mut text);
    serde_yaml::with::singleton_map_recursive::serialize(model, &mut serializer)?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}

/// The error for a field below `path` that left its range.
fn refusal(document: &Document, path: &str, error: &BadOption) -> SpecError {
    let parent = KeyPath::parse(path).unwrap_or_default();
    document.refuse(&parent.key(error.key), End::Value, error.found.clone(), error.expected)
}
