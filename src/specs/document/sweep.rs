//! What a document sweeps: the fields with their values as written, and putting one value after another into the tree.

use super::alias::canonical as unaliased;
use super::error::{SourceLocation, SpecError};
use super::layer::{Layer, SET};
use super::locate::PathEnd;
use super::merged::{Document, Origin, SweptEntry};
use super::mismatch::describe;
use super::path::{KeyPath, Step};
use super::tree::{get, put, remove};
use serde_yaml::Value;

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
