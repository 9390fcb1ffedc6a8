//! What a document sweeps: the fields with their values as written, and putting one value after another into the tree.

use super::{CHOICES, Document, Layer, SET, get, remove, unaliased};
use crate::specs::error::{SourceLocation, SpecError};
use crate::specs::locate::{PathEnd, locate};
use crate::specs::mismatch::describe;
use crate::specs::path::{KeyPath, Step};
use serde_yaml::{Mapping, Value};
use std::path::PathBuf;
use std::sync::Arc;

/// A field of `sweep:` as some source has it, before anybody asks what its values are.
#[derive(Clone, Debug)]
pub(in crate::specs) struct SweptEntry {
    /// The field that it means.
    pub(in crate::specs) field: KeyPath,
    /// Where its values stand.
    pub(in crate::specs) at: KeyPath,
    /// Number of its source, the strongest first.
    layer: usize,
    /// Folder that file names in it are relative to.
    pub(in crate::specs) folder: PathBuf,
    /// Its values.
    pub(in crate::specs) value: Value,
}

/// Where a swept value came from.
#[derive(Clone, Debug)]
pub(in crate::specs) struct Origin {
    /// The field, and where its values are written.
    pub(in crate::specs) written: Arc<SweptEntry>,
    /// Where among them this value is; nowhere for one that was computed.
    pub(in crate::specs) below: Option<Step>,
    /// Files that the value names: where below the field each name stood, the file and its text.
    pub(in crate::specs) files: Arc<Vec<(KeyPath, String, String)>>,
}

impl Origin {
    /// The place of `path`, if it is in the swept field.
    pub(super) fn place(&self, document: &Document, path: &KeyPath, end: PathEnd) -> Option<SourceLocation> {
        let rest = path.0.strip_prefix(self.written.field.0.as_slice())?;
        let files = self.files.iter().map(|(below, file, text)| (rest.strip_prefix(below.0.as_slice()), file, text));
        if let Some((inside, file, text)) = files.filter_map(|(inside, file, text)| Some((inside?, file, text))).next()
        {
            let (line, column) = locate(text, &KeyPath(inside.to_vec()), end).unwrap_or((1, 1));
            return Some(SourceLocation::File { file: file.clone(), line, column });
        }
        if rest.is_empty() && end == PathEnd::Key {
            return Some(document.place_swept(&self.written, &[], PathEnd::Key));
        }
        let below: Vec<Step> = self.below.iter().chain(rest).cloned().collect();
        Some(document.place_swept(&self.written, &below, end))
    }
}

impl Document {
    /// Takes `sweep:` out of the tree: its fields in the order in which they were written, weaker sources first. A
    /// stronger source's values take the place of a weaker one's; nothing as values takes the field out.
    ///
    /// # Errors
    /// A `sweep` that is no mapping, a field that one source, or the command line, sweeps twice.
    pub(in crate::specs) fn take_sweep(&mut self) -> Result<Vec<SweptEntry>, SpecError> {
        let sweep = KeyPath::default().key("sweep");
        let mut fields: Vec<SweptEntry> = Vec::new();
        for (number, layer) in self.layers.iter().enumerate().rev() {
            let mapping = match layer.rooted().get("sweep") {
                None => continue,
                Some(Value::Null) => {
                    fields.clear();
                    continue;
                }
                Some(Value::Mapping(mapping)) => mapping.clone(),
                Some(other) => {
                    return Err(layer.refuse(&sweep, describe(other), "a mapping from fields to their values"));
                }
            };
            for (key, value) in mapping {
                let refuse = |found: String| layer.refuse(&sweep, found, "paths of fields, such as `gp.kernel`");
                let key = key.as_str().ok_or_else(|| refuse(format!("the key `{}`", describe(&key))))?.to_owned();
                let field = unaliased(KeyPath::parse(&key).map_err(refuse)?);
                let written =
                    SweptEntry { at: sweep.key(&key), field, layer: number, folder: layer.folder.clone(), value };
                let same = fields.iter().position(|known| known.field == written.field);
                let known = same.map(|index| &self.layers[fields[index].layer]);
                if known.is_some_and(|known| known.name == layer.name || (known.is_option() && layer.is_option())) {
                    let place = layer.place(&written.at, PathEnd::Key);
                    let (found, expected) = ("a field that is swept already".into(), "each field once".into());
                    return Err(SpecError::Key { place, key: written.field, found, expected });
                }
                match (same, written.value.is_null()) {
                    (Some(index), true) => drop(fields.remove(index)),
                    (Some(index), false) => fields[index] = written,
                    (None, true) => {}
                    (None, false) => fields.push(written),
                }
            }
        }
        if let Value::Mapping(mapping) = &mut self.merged {
            mapping.remove("sweep");
        }
        Ok(fields)
    }

    /// Where the `--set` stands that says something of `field` or of a part of it.
    pub(in crate::specs) fn set_by(&self, field: &KeyPath) -> Option<SourceLocation> {
        let says = |layer: &&Layer| {
            layer.name.starts_with(SET) && (layer.root.0.starts_with(&field.0) || get(&layer.rooted(), field).is_some())
        };
        self.layers.iter().find(says).map(|layer| layer.place(field, PathEnd::Value))
    }

    /// The error for a place in the values of a swept field.
    pub(in crate::specs) fn refuse_swept(
        &self,
        written: &SweptEntry,
        below: &[Step],
        found: String,
        expected: &str,
    ) -> SpecError {
        let place = self.place_swept(written, below, PathEnd::Value);
        SpecError::Key { place, key: written.field.clone(), found, expected: expected.to_owned() }
    }

    /// Where `below` the values of a swept field stands, or what of it was written.
    pub(in crate::specs) fn place_swept(&self, written: &SweptEntry, below: &[Step], end: PathEnd) -> SourceLocation {
        let layer = &self.layers[written.layer];
        let full = KeyPath([written.at.0.as_slice(), below].concat());
        let (path, end) =
            if get(&layer.rooted(), &full).is_some() { (&full, end) } else { (&written.at, PathEnd::Value) };
        layer.place(path, end)
    }

    /// Puts a swept value where its field stands, in place of what was there.
    ///
    /// # Errors
    /// What stands on the way that holds no fields.
    pub(in crate::specs) fn put(&mut self, field: &KeyPath, value: Value) -> Result<(), String> {
        put(&mut self.merged, &field.0, value)
    }

    /// The value at `path`.
    pub(in crate::specs) fn value(&self, path: &KeyPath) -> Option<&Value> {
        get(&self.merged, path)
    }

    /// Takes a key of the root out.
    pub(in crate::specs) fn drop_key(&mut self, key: &str) {
        remove(&mut self.merged, &KeyPath::default().key(key));
    }

    /// Notes where the swept values that stand in the tree came from, so that errors point there.
    pub(in crate::specs) fn note(&mut self, origins: Vec<Origin>) {
        self.origins = origins;
    }

    /// Reads the file that a swept value names at `below` its field: its content, its name as the user would write it,
    /// and its text.
    pub(in crate::specs) fn read_swept_file(
        &self,
        written: &SweptEntry,
        below: &[Step],
        name: &str,
    ) -> Result<(Value, String, String), SpecError> {
        let place = self.place_swept(written, below, PathEnd::Value);
        let layer = Layer::file(&written.folder.join(name), Some((&written.field, place)))?;
        Ok((layer.value, layer.name, layer.text))
    }
}

/// Puts `value` into `tree` at `steps`, making the mappings on the way that are not there.
pub(in crate::specs) fn put(tree: &mut Value, steps: &[Step], value: Value) -> Result<(), String> {
    let Some((step, below)) = steps.split_first() else {
        *tree = value;
        return Ok(());
    };
    if tree.is_null() && matches!(step, Step::Key(_)) {
        *tree = Value::Mapping(Mapping::new());
    }
    let next = match (tree, step) {
        (Value::Mapping(mapping), Step::Key(key)) => {
            // Another alternative takes the place of the one that stands there, as it does in a file.
            let choice = CHOICES.contains(&key.as_str());
            let holder = mapping.entry(Value::from(key.as_str())).or_insert(Value::Null);
            if let (true, Some(Step::Key(name)), Value::Mapping(chosen)) = (choice, below.first(), &mut *holder)
                && chosen.len() == 1
                && !chosen.contains_key(name.as_str())
                && !chosen.contains_key("robot")
            {
                chosen.clear();
            }
            holder
        }
        (Value::Sequence(items), Step::Item(index)) => {
            let count = items.len();
            items.get_mut(*index).ok_or_else(|| format!("a list of {count}"))?
        }
        (other, _) => return Err(describe(other)),
    };
    put(next, below, value)
}
