//! Model files and plant files, read and checked on their own.

use super::discovery::check_entries;
use super::document::Document;
use super::error::SpecError;
use super::locate::PathEnd;
use super::path::KeyPath;
use super::plant::PlantSpec;
use crate::base::BadOption;
use crate::discovery::Options;
use crate::effects::{EffectSpec, Model};
use std::path::{Path, PathBuf};

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

/// Reads and checks a plant file: a robot as in an experiment's `plant`, whose model may be the name of a model file. The name of
/// a recording to be replayed counts from the folder of the plant file, as that of a model does.
///
/// # Errors
/// As [`read_model`].
pub fn read_plant(file: &Path) -> Result<PlantSpec, SpecError> {
    let document = Document::read(file, &[], &PlantSpec::model_paths(&KeyPath::default()))?;
    let mut plant = document.parse::<PlantSpec>()?;
    plant.check().map_err(|(path, error)| refusal(&document, &path, &error))?;
    if let (PlantSpec::Replay(options), Some(folder)) = (&mut plant, file.parent()) {
        options.recording = folder.join(&options.recording);
    }
    Ok(plant)
}

/// The files that a model, a plant or settings are read from: `file`, what it extends, and the models that it names. Only
/// `file` itself where it cannot be read.
pub fn files_behind(file: &Path) -> Vec<PathBuf> {
    let document = Document::read(file, &[], &PlantSpec::model_paths(&KeyPath::default()));
    document.map_or_else(|_| vec![file.to_owned()], |document| document.files())
}

/// Reads and checks settings of a discovery.
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

/// The text of `file` with the last `added` effects of `model` written below its own, so that all that people wrote in
/// it stays; the whole model written anew where that cannot be done.
///
/// # Errors
/// As [`model_text`]; a file that cannot be read is written anew.
pub fn extended_text(file: &Path, model: &Model, added: usize) -> Result<String, serde_yaml::Error> {
    let written = std::fs::read_to_string(file).unwrap_or_default();
    let line = |effect: &EffectSpec| -> Result<String, serde_yaml::Error> {
        let name = effect.card().name;
        let value = serde_json::to_value(effect).map_err(<serde_yaml::Error as serde::ser::Error>::custom)?;
        let fields = value[name].to_string().replace('"', "").replace(':', ": ").replace(',', ", ");
        Ok(format!("  - {name}: {fields}\n"))
    };
    let lines: String = model.effects[model.effects.len() - added..].iter().map(line).collect::<Result<_, _>>()?;
    let extended = with_effects(&written, &lines);
    let same = |text: &String| {
        let read: Result<Model, _> =
            serde_yaml::with::singleton_map_recursive::deserialize(serde_yaml::Deserializer::from_str(text));
        read.is_ok_and(|read| read == *model)
    };
    extended.filter(same).map_or_else(|| model_text(model), Ok)
}

/// `written` with `lines` below its last effect, where `effects` is its last key.
fn with_effects(written: &str, lines: &str) -> Option<String> {
    let mut text = written.to_owned();
    if !text.ends_with('\n') {
        text.push('\n');
    }
    let Some(start) = text.lines().position(|line| line.starts_with("effects:")) else {
        return Some(format!("{text}effects:\n{lines}"));
    };
    let head: String = text.lines().take(start).map(|line| format!("{line}\n")).collect();
    let (own, below) = text.lines().skip(start).collect::<Vec<_>>().split_first().map(|(a, b)| (*a, b.to_vec()))?;
    let comment = own.split_once('#').map_or_else(String::new, |(_, comment)| format!("  # {}", comment.trim()));
    if own["effects:".len()..].trim_start().starts_with("[]") {
        let below: String = below.iter().map(|line| format!("{line}\n")).collect();
        return Some(format!("{head}effects:{comment}\n{lines}{below}"));
    }
    Some(format!("{text}{lines}"))
}

/// The error for a field below `path` that left its range.
fn refusal(document: &Document, path: &str, error: &BadOption) -> SpecError {
    let parent = KeyPath::parse(path).unwrap_or_default();
    document.refuse(&parent.key(error.key), PathEnd::Value, error.found.clone(), error.expected)
}
