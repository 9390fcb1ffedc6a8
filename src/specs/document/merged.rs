//! The merged tree of a spec, and where each of its values was written.
//!
//! Mappings merge key by key, the extending file's values winning; lists and scalars replace what
//! they override. Where a key may name a file (a model), that file's content takes the name's
//! place.

use super::error::{SourceLocation, SpecError};
use super::inherited;
use super::invisible;
use super::layer::{Layer, canonical};
use super::locate::{PathEnd, locate};
use super::mismatch::describe;
use super::path::{KeyPath, Step};
use super::tree::{get, remove};
use serde_yaml::{Mapping, Value};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The merged tree and its sources, strongest first.
#[derive(Clone, Debug)]
pub struct Document {
    pub(super) layers: Vec<Layer>,
    pub(crate) merged: Value,
    /// Keys of the root that are no part of the typed value.
    pub(super) root_keys: &'static [&'static str],
    /// The file as the user named it.
    pub file: String,
    /// Sources of the swept values in the tree.
    pub(crate) origins: Vec<Origin>,
    /// What the user should know of it: keys under former names, inherited kinds of training.
    pub(crate) notes: Vec<String>,
}

impl Document {
    /// Reads `file`, the files that it `extends`, the overrides `path.to.key=value` in `sets`, and
    /// the files named at the paths `includes`.
    ///
    /// # Errors
    /// A missing file, text that is not YAML, a cycle of `extends`, a malformed override.
    pub fn read(file: &Path, sets: &[String], includes: &[KeyPath]) -> Result<Document, SpecError> {
        let document = Document::read_swept(file, sets, &[], includes)?;
        Ok(Document { root_keys: &["extends"], ..document })
    }

    /// As [`Document::read`], with the `--sweep` options.
    pub(crate) fn read_swept(
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
        let mut extended_files = Vec::new();
        while let Some(mut layer) = next {
            extended_files.push(canonical(Path::new(&layer.name)));
            next = layer.parent(&extended_files)?;
            layer.push_with_included(includes, &mut layers)?;
        }
        let mut merged = Value::Mapping(Mapping::new());
        for layer in layers.iter().rev() {
            if layer.replaces {
                remove(&mut merged, &layer.root);
            }
            layer.merge_into(&mut merged)?;
        }
        let renamed = layers.iter().rev().flat_map(Layer::notes);
        let notes = renamed.chain(inherited::note(&layers, &merged)).collect();
        let root_keys: &[&str] = &["extends", "sweep"];
        Ok(Document {
            layers,
            merged,
            root_keys,
            file: file.display().to_string(),
            origins: Vec::new(),
            notes,
        })
    }

    /// Every file that was read for it.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        self.layers
            .iter()
            .filter(|layer| !layer.is_option())
            .map(|layer| PathBuf::from(&layer.name))
            .collect()
    }

    /// The error for the value at `path`.
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
            let same =
                value.as_str() == Some(found) || (number.is_some() && value.as_f64() == number);
            same && path.0.last() == Some(&Step::Key(key.to_owned()))
        })
    }

    fn search(
        &self,
        below: &KeyPath,
        matches: &dyn Fn(&KeyPath, &Value) -> bool,
    ) -> Option<KeyPath> {
        let value = get(&self.merged, below)?;
        if matches(below, value) {
            return Some(below.clone());
        }
        match value {
            Value::Mapping(mapping) => mapping
                .keys()
                .filter_map(Value::as_str)
                .find_map(|key| self.search(&below.key(key), matches)),
            Value::Sequence(items) => {
                (0..items.len()).find_map(|index| self.search(&below.item(index), matches))
            }
            _ => None,
        }
    }

    /// The error for `path`, with the given texts.
    pub fn refuse(
        &self,
        path: &KeyPath,
        end: PathEnd,
        found: String,
        expected: impl Into<String>,
    ) -> SpecError {
        SpecError::Key {
            place: self.place(path, end),
            key: path.clone(),
            found: invisible::named(found),
            expected: expected.into(),
        }
    }

    /// Location of `path`, or of its nearest existing parent.
    pub fn place(&self, path: &KeyPath, end: PathEnd) -> SourceLocation {
        if let Some(place) =
            self.origins.iter().rev().find_map(|origin| origin.place(self, path, end))
        {
            return place;
        }
        // A value in an overridden layer is not part of the document.
        match self.owner(path).filter(|_| self.has(path)) {
            Some(layer) => layer.place(path, end),
            None if path.0.is_empty() => {
                SourceLocation::File { file: self.file.clone(), line: 1, column: 1 }
            }
            None => self.place(&path.parent(), PathEnd::Value),
        }
    }

    /// The strongest source that holds `path`.
    fn owner(&self, path: &KeyPath) -> Option<&Layer> {
        let holds = |layer: &&Layer| layer.get(path).is_some();
        // An option below the path holds it only where nothing else does.
        let above_option = |layer: &Layer| layer.root.0.len() > path.0.len();
        let at_or_above = self.layers.iter().find(|layer| !above_option(layer) && holds(layer));
        at_or_above.or_else(|| self.layers.iter().find(holds))
    }

    /// Rank of the source that the value at `path` is from, 0 for the strongest.
    pub(crate) fn rank(&self, path: &KeyPath) -> Option<usize> {
        let swept =
            self.origins.iter().rev().find(|origin| path.0.starts_with(&origin.written.field.0));
        if let Some(origin) = swept {
            return Some(origin.written.layer);
        }
        let owner = self.owner(path).filter(|_| self.has(path))?;
        self.layers.iter().position(|layer| std::ptr::eq(layer, owner))
    }

    /// The value at `path` as the sources weaker than `rank` say it.
    pub(crate) fn below(&self, rank: usize, path: &KeyPath) -> Option<Value> {
        let mut merged = Value::Mapping(Mapping::new());
        for layer in self.layers.get(rank + 1..)?.iter().rev() {
            layer.merge_into(&mut merged).ok()?;
        }
        get(&merged, path).cloned()
    }

    /// Location of `below` in the values of a swept field, or of its nearest existing parent.
    pub(crate) fn place_swept(
        &self,
        written: &SweptEntry,
        below: &[Step],
        end: PathEnd,
    ) -> SourceLocation {
        let layer = &self.layers[written.layer];
        let full = KeyPath([written.at.0.as_slice(), below].concat());
        let (path, end) =
            if layer.get(&full).is_some() { (&full, end) } else { (&written.at, PathEnd::Value) };
        layer.place(path, end)
    }
}

/// An entry of `sweep:` in one source, with its values not yet expanded.
#[derive(Clone, Debug)]
pub(crate) struct SweptEntry {
    /// The swept field.
    pub(crate) field: KeyPath,
    /// Path of its values.
    pub(crate) at: KeyPath,
    /// Index of its source, the strongest first.
    pub(super) layer: usize,
    /// Folder that file names in it are relative to.
    pub(crate) folder: PathBuf,
    /// Its values, as written.
    pub(crate) value: Value,
}

/// Source of a swept value.
#[derive(Clone, Debug)]
pub(crate) struct Origin {
    /// The entry of `sweep:`.
    pub(crate) written: Arc<SweptEntry>,
    /// Position of this value in the entry; none for a computed value.
    pub(crate) below: Option<Step>,
    /// Files that the value names: path of the name below the field, the file, its text.
    pub(crate) files: Arc<Vec<(KeyPath, String, String)>>,
}

impl Origin {
    /// Location of `path`, if it is in the swept field.
    pub(super) fn place(
        &self,
        document: &Document,
        path: &KeyPath,
        end: PathEnd,
    ) -> Option<SourceLocation> {
        let below_field = path.0.strip_prefix(self.written.field.0.as_slice())?;
        let files = self
            .files
            .iter()
            .map(|(below, file, text)| (below_field.strip_prefix(below.0.as_slice()), file, text));
        if let Some((inside, file, text)) =
            files.filter_map(|(inside, file, text)| Some((inside?, file, text))).next()
        {
            let (line, column) = locate(text, &KeyPath(inside.to_vec()), end).unwrap_or((1, 1));
            return Some(SourceLocation::File { file: file.clone(), line, column });
        }
        if below_field.is_empty() && end == PathEnd::Key {
            return Some(document.place_swept(&self.written, &[], PathEnd::Key));
        }
        let below: Vec<Step> = self.below.iter().chain(below_field).cloned().collect();
        Some(document.place_swept(&self.written, &below, end))
    }
}
