//! A spec as it is read: a file, the files it extends, and overrides from the command line, merged into one tree that
//! still knows where each value came from.
//!
//! Mappings merge key by key, the extending file's values winning; lists and scalars replace what they override.
//! Where a key may name a file (a model), that file's content takes the name's place.

mod sweep;

use super::alias::canonical as unaliased;
use super::error::{SourceLocation, SpecError};
use super::locate::{PathEnd, locate};
use super::mismatch::{Mismatch, describe, deserialize};
use super::path::{KeyPath, Step};
use super::sweep_option;
use serde::de::DeserializeOwned;
use serde_yaml::{Mapping, Value};
use std::path::{Path, PathBuf};

pub(super) use sweep::{Origin, SweptEntry, put};

/// One source of values.
#[derive(Clone, Debug)]
struct Layer {
    /// The file, or the option, as the user wrote it.
    name: String,
    text: String,
    value: Value,
    /// Folder that file names in it are relative to.
    folder: PathBuf,
    /// The path that its text is the value of: the root, or for an option and an included file that of the key.
    root: KeyPath,
    /// What stood at `root` gives way to this layer instead of merging with it.
    replaces: bool,
}

/// The merged tree and its sources, strongest first.
#[derive(Clone, Debug)]
pub struct Document {
    layers: Vec<Layer>,
    merged: Value,
    /// The file as the user named it.
    pub file: String,
    /// Where swept values came from, while they stand in the tree.
    origins: Vec<Origin>,
}

impl Document {
    /// Reads `file`, what it `extends`, the overrides `path.to.key=value` in `sets`, and the files that are named at
    /// the paths `includes`.
    ///
    /// # Errors
    /// A missing file, text that is not YAML, a cycle of `extends`, a malformed override.
    pub fn read(file: &Path, sets: &[String], includes: &[KeyPath]) -> Result<Document, SpecError> {
        Document::read_swept(file, sets, &[], includes)
    }

    /// The same with what the command line sweeps.
    pub(super) fn read_swept(
        file: &Path,
        sets: &[String],
        sweeps: &[String],
        includes: &[KeyPath],
    ) -> Result<Document, SpecError> {
        let mut layers = Vec::new();
        for sweep in sweeps.iter().rev() {
            layers.push(Layer::sweep(sweep)?);
        }
        for set in sets.iter().rev() {
            Layer::option(set)?.push_with_included(includes, &mut layers)?;
        }
        let mut next = Some(Layer::file(file, None)?);
        let mut seen = Vec::new();
        while let Some(mut layer) = next {
            seen.push(canonical(Path::new(&layer.name)));
            next = layer.parent(&seen)?;
            layer.push_with_included(includes, &mut layers)?;
        }
        let mut merged = Value::Mapping(Mapping::new());
        for layer in layers.iter().rev() {
            if layer.replaces {
                remove(&mut merged, &layer.root);
            }
            merge(&mut merged, layer.rooted());
        }
        Ok(Document { layers, merged, file: file.display().to_string(), origins: Vec::new() })
    }

    /// Every file that was read for it.
    pub(super) fn files(&self) -> Vec<PathBuf> {
        self.layers.iter().filter(|layer| !layer.is_option()).map(|layer| PathBuf::from(&layer.name)).collect()
    }

    /// The document as a `T`.
    ///
    /// # Errors
    /// [`SpecError::Key`] for an unknown or missing key or a value of the wrong type, with its source location.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, SpecError> {
        deserialize(&self.merged)
            .map_err(|wrong: Mismatch| self.refuse(&wrong.key, wrong.end, wrong.found, wrong.expected))
    }

    /// The error for the value at `path`, found as it stands.
    pub fn wrong(&self, path: &KeyPath, expected: impl Into<String>) -> SpecError {
        let found = get(&self.merged, path).map_or_else(|| "nothing".to_owned(), describe);
        self.refuse(path, PathEnd::Value, found, expected)
    }

    /// True when the document has a value at `path`.
    pub fn has(&self, path: &KeyPath) -> bool {
        get(&self.merged, path).is_some()
    }

    /// True when the value at `path` is written as nothing (`null`, `~` or left empty).
    pub fn is_null(&self, path: &KeyPath) -> bool {
        get(&self.merged, path).is_some_and(Value::is_null)
    }

    /// The first path below `below` that ends in `key` and holds the value written `found`.
    pub fn find(&self, below: &KeyPath, key: &str, found: &str) -> Option<KeyPath> {
        let number: Option<f64> = found.parse().ok();
        self.search(below, &|path, value| {
            let same = value.as_str() == Some(found) || (number.is_some() && value.as_f64() == number);
            same && path.0.last() == Some(&Step::Key(key.to_owned()))
        })
    }

    fn search(&self, below: &KeyPath, wanted: &dyn Fn(&KeyPath, &Value) -> bool) -> Option<KeyPath> {
        let value = get(&self.merged, below)?;
        if wanted(below, value) {
            return Some(below.clone());
        }
        match value {
            Value::Mapping(mapping) => {
                mapping.keys().filter_map(Value::as_str).find_map(|key| self.search(&below.key(key), wanted))
            }
            Value::Sequence(items) => (0..items.len()).find_map(|index| self.search(&below.item(index), wanted)),
            _ => None,
        }
    }

    /// The error for `path`, in the given words.
    pub fn refuse(&self, path: &KeyPath, end: PathEnd, found: String, expected: impl Into<String>) -> SpecError {
        SpecError::Key { place: self.place(path, end), key: path.clone(), found, expected: expected.into() }
    }

    /// Where `path`, or what of it exists, was written.
    pub fn place(&self, path: &KeyPath, end: PathEnd) -> SourceLocation {
        if let Some(place) = self.origins.iter().rev().find_map(|origin| origin.place(self, path, end)) {
            return place;
        }
        // What is only in a layer that another one overrides is not there.
        match self.owner(path).filter(|_| self.has(path)) {
            Some(layer) => layer.place(path, end),
            None if path.0.is_empty() => SourceLocation::File { file: self.file.clone(), line: 1, column: 1 },
            None => self.place(&path.parent(), PathEnd::Value),
        }
    }

    /// The strongest source that holds `path`.
    fn owner(&self, path: &KeyPath) -> Option<&Layer> {
        let above_option = |layer: &Layer| layer.root.0.len() > path.0.len();
        self.layers.iter().find(|layer| !above_option(layer) && get(&layer.rooted(), path).is_some())
    }
}

/// How the names of sources on the command line begin.
const SET: &str = "--set ";
const SWEEP: &str = "--sweep ";

impl Layer {
    /// A file as the layer below `include` (a path and where its name stands), or as the root.
    fn file(path: &Path, include: Option<(&KeyPath, SourceLocation)>) -> Result<Layer, SpecError> {
        let name = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|error| {
            let missing = error.kind() == std::io::ErrorKind::NotFound;
            let found = if missing { format!("no file `{name}`") } else { format!("`{name}`: {error}") };
            let expected = "the name of a YAML file";
            match &include {
                Some((key, place)) => {
                    let (place, key) = (place.clone(), (*key).clone());
                    SpecError::Key { place, key, found, expected: expected.into() }
                }
                None => SpecError::File { file: name.clone(), found, expected },
            }
        })?;
        let value = yaml(&text, &name)?;
        let value = if value.is_null() { Value::Mapping(Mapping::new()) } else { value };
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        let root = include.as_ref().map_or_else(KeyPath::default, |(key, _)| (*key).clone());
        let layer = Layer { name, text, value, folder, root, replaces: include.is_some() };
        if !layer.value.is_mapping() {
            return Err(layer.refuse(&layer.root, describe(&layer.value), "a mapping of keys to values"));
        }
        layer.plain()
    }

    fn option(set: &str) -> Result<Layer, SpecError> {
        let name = format!("{SET}{set}");
        let refuse = |found: String| SpecError::Key {
            place: SourceLocation::Option(name.clone()),
            key: KeyPath::default(),
            found,
            expected: "path.to.key=value".to_owned(),
        };
        let (path, text) = set.split_once('=').ok_or_else(|| refuse(format!("`{set}`")))?;
        let root = unaliased(KeyPath::parse(path.trim()).map_err(refuse)?);
        if root.0.iter().any(|step| matches!(step, Step::Item(_))) {
            return Err(refuse(format!("`{path}`, which names one item of a list")));
        }
        let value = yaml(text, &name)?;
        Layer { name, text: text.to_owned(), value, folder: PathBuf::new(), root, replaces: false }.plain()
    }

    /// Refuses keys that are not text, and tags.
    fn plain(self) -> Result<Layer, SpecError> {
        match not_plain(&self.value, &self.root) {
            Some((path, found)) => Err(self.refuse(&path, found, "plain keys and values")),
            None => Ok(self),
        }
    }

    /// What the command line sweeps, as the entry of `sweep:` that it stands for.
    fn sweep(option: &str) -> Result<Layer, SpecError> {
        let name = format!("{SWEEP}{option}");
        let (path, values) = sweep_option::parse(option).map_err(|found| SpecError::Key {
            place: SourceLocation::Option(name.clone()),
            key: KeyPath::default(),
            found,
            expected: format!("path.to.key= and {}", sweep_option::EXPECTED),
        })?;
        let value = Value::Mapping(Mapping::from_iter([(Value::from(path.to_string()), values)]));
        let root = KeyPath::default().key("sweep");
        Ok(Layer { name, text: option.to_owned(), value, folder: PathBuf::new(), root, replaces: false })
    }

    fn is_option(&self) -> bool {
        self.name.starts_with(SET) || self.name.starts_with(SWEEP)
    }

    /// Appends this layer and, below it, the files that it names at the paths `includes`.
    fn push_with_included(mut self, includes: &[KeyPath], layers: &mut Vec<Layer>) -> Result<(), SpecError> {
        let mut included = Vec::new();
        for path in includes {
            let Some(Value::String(name)) = get(&self.rooted(), path).cloned() else { continue };
            let file = self.folder.join(&name);
            included.push(Layer::file(&file, Some((path, self.place(path, PathEnd::Value))))?);
            match path.0.strip_prefix(self.root.0.as_slice()) {
                Some([]) | None => self.value = Value::Mapping(Mapping::new()),
                Some(below) => remove(&mut self.value, &KeyPath(below.to_vec())),
            }
        }
        layers.push(self);
        layers.append(&mut included);
        Ok(())
    }

    /// Takes `extends` out of this layer and reads the file that it names.
    fn parent(&mut self, seen: &[PathBuf]) -> Result<Option<Layer>, SpecError> {
        let path = KeyPath::default().key("extends");
        let Some(value) = self.value.get("extends").cloned() else { return Ok(None) };
        let expected = "the name of a spec beside this one";
        let Value::String(name) = &value else { return Err(self.refuse(&path, describe(&value), expected)) };
        let file = self.folder.join(name);
        if !file.is_file() {
            return Err(self.refuse(&path, format!("no file `{}`", file.display()), expected));
        }
        if seen.contains(&canonical(&file)) {
            return Err(self.refuse(&path, format!("`{name}`, which extends this file"), expected));
        }
        if let Value::Mapping(mapping) = &mut self.value {
            mapping.remove("extends");
        }
        Layer::file(&file, None).map(Some)
    }

    fn refuse(&self, path: &KeyPath, found: String, expected: &str) -> SpecError {
        SpecError::Key {
            place: self.place(path, PathEnd::Value),
            key: path.clone(),
            found,
            expected: expected.to_owned(),
        }
    }

    fn place(&self, path: &KeyPath, end: PathEnd) -> SourceLocation {
        if self.is_option() {
            return SourceLocation::Option(self.name.clone());
        }
        let below = path.0.strip_prefix(self.root.0.as_slice()).unwrap_or_default();
        let (line, column) = locate(&self.text, &KeyPath(below.to_vec()), end).unwrap_or((1, 1));
        SourceLocation::File { file: self.name.clone(), line, column }
    }

    /// The value under its path from the root of the document.
    fn rooted(&self) -> Value {
        self.root.0.iter().rev().fold(self.value.clone(), |value, step| match step {
            Step::Key(key) => Value::Mapping(Mapping::from_iter([(Value::from(key.as_str()), value)])),
            Step::Item(_) => value,
        })
    }
}

fn yaml(text: &str, name: &str) -> Result<Value, SpecError> {
    serde_yaml::from_str(text).map_err(|error| {
        let (line, column) = error.location().map_or((1, 1), |at| (at.line(), at.column()));
        let place = if name.starts_with(SET) {
            SourceLocation::Option(name.to_owned())
        } else {
            SourceLocation::File { file: name.to_owned(), line, column }
        };
        let words = error.to_string();
        let found = words.split(" at line ").next().unwrap_or_default().to_owned();
        SpecError::Syntax { place, found }
    })
}

fn canonical(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

/// The first mapping below `path` with a key that is not text, or the first tag.
fn not_plain(value: &Value, path: &KeyPath) -> Option<(KeyPath, String)> {
    match value {
        Value::Mapping(mapping) => mapping.iter().find_map(|(key, value)| match key {
            Value::String(key) => not_plain(value, &path.key(key)),
            other => Some((path.clone(), format!("the key `{}`", describe(other)))),
        }),
        Value::Sequence(items) => items.iter().enumerate().find_map(|(index, item)| not_plain(item, &path.item(index))),
        Value::Tagged(tagged) => Some((path.clone(), format!("the tag `{}`", tagged.tag))),
        _ => None,
    }
}

/// Lays `over` over `under`.
fn merge(under: &mut Value, over: Value) {
    match (under, over) {
        (Value::Mapping(under), Value::Mapping(over)) => {
            for (key, value) in over {
                match under.get_mut(&key) {
                    Some(below) if !other_choice(&key, below, &value) => merge(below, value),
                    _ => {
                        under.insert(key, value);
                    }
                }
            }
        }
        (under, over) => *under = over,
    }
}

/// Keys whose value is one alternative with its settings, such as `plant: {simulated: {…}}`: another alternative
/// replaces the first instead of joining it.
const CHOICES: [&str; 3] = ["model", "plant", "layout"];

fn other_choice(key: &Value, under: &Value, over: &Value) -> bool {
    let (Value::Mapping(under), Value::Mapping(over)) = (under, over) else { return false };
    CHOICES.iter().any(|choice| key == *choice) && over.keys().any(|name| !under.contains_key(name))
}

/// Takes the value at `path` out, if there is one.
fn remove(value: &mut Value, path: &KeyPath) {
    let Some((Step::Key(last), above)) = path.0.split_last() else { return };
    let holder = above.iter().try_fold(value, |value, step| match step {
        Step::Key(key) => value.get_mut(key.as_str()),
        Step::Item(index) => value.get_mut(*index),
    });
    if let Some(Value::Mapping(mapping)) = holder {
        mapping.remove(last.as_str());
    }
}

/// The value at `path`.
pub(super) fn get<'a>(value: &'a Value, path: &KeyPath) -> Option<&'a Value> {
    path.0.iter().try_fold(value, |value, step| match (step, value) {
        (Step::Key(key), Value::Mapping(mapping)) => mapping.get(key.as_str()),
        (Step::Item(index), Value::Sequence(items)) => items.get(*index),
        _ => None,
    })
}

#[cfg(test)]
mod tests;
