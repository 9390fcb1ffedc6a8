//! The sweep of a document: its entries as written, and setting values of swept fields in the tree.

use super::alias::canonical as unaliased;
use super::error::{SourceLocation, SpecError};
use super::layer::{Layer, SET};
use super::locate::PathEnd;
use super::merged::{Document, SweptEntry};
use super::mismatch::describe;
use super::path::{KeyPath, Step};
use serde_yaml::Value;

impl Document {
    /// Removes `sweep:` from the tree and returns its entries in the order in which they were
    /// written, weaker sources first. A stronger source's values replace a weaker one's; `null`
    /// removes the field.
    ///
    /// # Errors
    /// A `sweep` that is not a mapping; a field that one source, or the command line, sweeps twice.
    pub(crate) fn take_sweep(&mut self) -> Result<Vec<SweptEntry>, SpecError> {
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
                    return Err(layer.refuse(
                        &sweep,
                        describe(other),
                        "a mapping from fields to their values",
                    ));
                }
            };
            for (key, value) in mapping {
                let refuse = |found: String| {
                    layer.refuse(&sweep, found, "paths of fields, such as `gp.kernel`")
                };
                let key = key
                    .as_str()
                    .ok_or_else(|| refuse(format!("the key `{}`", describe(&key))))?
                    .to_owned();
                let (field, renamed) = unaliased(KeyPath::parse(&key).map_err(refuse)?);
                self.notes.extend(renamed.map(|renamed| {
                    let place = layer.place(&sweep.key(&key), PathEnd::Key);
                    format!("{place}: `{}` is now called `{}`", renamed.former, renamed.present)
                }));
                let written = SweptEntry {
                    at: sweep.key(&key),
                    field,
                    layer: number,
                    folder: layer.folder.clone(),
                    value,
                };
                let earlier = fields.iter().position(|field| field.field == written.field);
                let earlier_layer = earlier.map(|index| &self.layers[fields[index].layer]);
                let is_same = |other: &Layer| {
                    other.name == layer.name || (other.is_option() && layer.is_option())
                };
                if earlier_layer.is_some_and(is_same) {
                    let place = layer.place(&written.at, PathEnd::Key);
                    let (found, expected) =
                        ("a field that is already swept".into(), "each field once".into());
                    return Err(SpecError::Key { place, key: written.field, found, expected });
                }
                match (earlier, written.value.is_null()) {
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

    /// Location of the `--set` that sets `field` or a part of it.
    pub(crate) fn set_by(&self, field: &KeyPath) -> Option<SourceLocation> {
        let sets_field = |layer: &&Layer| {
            layer.name.starts_with(SET)
                && (layer.root.0.starts_with(&field.0) || layer.get(field).is_some())
        };
        self.layers.iter().find(sets_field).map(|layer| layer.place(field, PathEnd::Value))
    }

    /// The error for a value of a swept field.
    pub(crate) fn refuse_swept(
        &self,
        written: &SweptEntry,
        below: &[Step],
        found: String,
        expected: &str,
    ) -> SpecError {
        let place = self.place_swept(written, below, PathEnd::Value);
        SpecError::Key { place, key: written.field.clone(), found, expected: expected.to_owned() }
    }

    /// Reads the file that a swept value names at `below` its field: its content, its name and its
    /// text.
    pub(crate) fn read_swept_file(
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
