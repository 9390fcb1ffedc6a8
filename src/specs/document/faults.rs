//! Reading the tree as a typed value: all keys and values that do not fit, and inherited entries
//! that `null` drops.

use super::error::SpecError;
use super::merged::Document;
use super::mismatch::deserialize;
use super::path::{KeyPath, Step};
use super::tree::{get, remove};
use serde::de::DeserializeOwned;
use serde_yaml::Value;

/// Most faults that are told at once.
const MAX_FAULTS: usize = 20;

impl Document {
    /// The document as a `T`. An entry that a weaker source has and a stronger one sets to `null`
    /// is dropped where the entry itself cannot be `null`.
    ///
    /// # Errors
    /// [`SpecError::Key`] for an unknown or missing key or a value of the wrong type, with its
    /// source location; [`SpecError::Several`] where there are more of them.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, SpecError> {
        let mut tree = self.merged.clone();
        // A mapping is dropped at once: read as nothing, it would be one of defaults.
        self.dropped_mappings(&self.merged, &KeyPath::default())
            .iter()
            .for_each(|entry| remove(&mut tree, entry));
        if let Ok(read) = deserialize(&tree, self.root_keys) {
            return Ok(read);
        }
        let (mut removed, mut faults) = (Vec::new(), Vec::new());
        loop {
            let wrong = match deserialize(&tree, self.root_keys) {
                Ok(read) if faults.is_empty() => return Ok(read),
                Ok(_) => break,
                Err(wrong) => wrong,
            };
            // What follows from a fault that was told is none of its own; a key that is missing
            // beside an unknown one is likely that one.
            let absent = get(&tree, &wrong.key).is_none();
            let follows = |removed_key: &KeyPath| {
                removed_key.0.starts_with(&wrong.key.0)
                    || (absent && removed_key.parent() == wrong.key.parent())
            };
            if removed.iter().any(follows) {
                break;
            }
            let key = wrong.key.clone();
            // An entry that is needed is missing once it is dropped.
            if let Some(dropped) = self.dropped(&key).filter(|entry| get(&tree, entry).is_some()) {
                remove(&mut tree, &dropped);
                continue;
            }
            let one_of_a_list = matches!(key.0.last(), Some(Step::Item(_)) | None);
            faults.push(self.refuse(&wrong.key, wrong.end, wrong.found, wrong.expected));
            if one_of_a_list || absent || faults.len() == MAX_FAULTS {
                break;
            }
            remove(&mut tree, &key);
            removed.push(key);
        }
        Err(SpecError::of_all(faults))
    }

    /// The entries at and below `path` that are `null` in the tree and a mapping in a weaker
    /// source.
    fn dropped_mappings(&self, value: &Value, path: &KeyPath) -> Vec<KeyPath> {
        let is_mapping = |value: Option<Value>| value.is_some_and(|value| value.is_mapping());
        match value {
            Value::Mapping(mapping) => {
                let named = mapping
                    .iter()
                    .filter_map(|(key, value)| Some((path.key(key.as_str()?), value)));
                named.flat_map(|(path, value)| self.dropped_mappings(value, &path)).collect()
            }
            Value::Null if self.layers.iter().any(|layer| is_mapping(layer.get(path))) => {
                vec![path.clone()]
            }
            _ => Vec::new(),
        }
    }

    /// The entry at or above `path` that is `null` in the tree and something else in a weaker
    /// source.
    fn dropped(&self, path: &KeyPath) -> Option<KeyPath> {
        let entry = (1..=path.0.len()).map(|depth| KeyPath(path.0[..depth].to_vec()));
        let entry =
            entry.into_iter().find(|entry| get(&self.merged, entry).is_some_and(Value::is_null))?;
        let has_value = |value: Option<Value>| value.is_some_and(|value| !value.is_null());
        self.layers.iter().any(|layer| has_value(layer.get(&entry))).then_some(entry)
    }
}
