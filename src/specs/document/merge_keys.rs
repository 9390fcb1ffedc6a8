//! Merge keys of YAML 1.1 (<https://yaml.org/type/merge.html>): `<<: *rod` gives a mapping the keys
//! of another one, `<<: [*rod, *light]` those of several.
//!
//! A key that the mapping has itself wins over a merged one, and an earlier mapping of a list over
//! a later one. Values are replaced, not merged. What is merged may have merge keys of its own.

use super::mismatch::describe;
use super::path::KeyPath;
use serde_yaml::{Mapping, Value};

/// The merge key.
const MERGE: &str = "<<";

/// A key that a mapping has from another one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct MergedKey {
    /// Its path.
    pub(super) present: KeyPath,
    /// Its path in the text, through the merge key.
    pub(super) written: KeyPath,
}

/// A merge key whose value has no keys: its path, and what was found there.
pub(super) type NoMapping = (KeyPath, String);

/// What belongs below a merge key.
pub(super) const EXPECTED: &str = "a mapping, or a list of mappings, whose keys are merged";

/// Replaces the merge keys in `value`, which stands at `path`, by the keys that they stand for.
///
/// # Errors
/// The first merge key without a mapping.
pub(super) fn apply(value: &mut Value, path: &KeyPath) -> Result<Vec<MergedKey>, NoMapping> {
    let mut merged = Vec::new();
    resolve(value, path, &mut merged)?;
    Ok(merged)
}

/// The value of a YAML text with its merge keys replaced; `None` where it is none.
pub(in crate::specs) fn read(text: &str) -> Option<Value> {
    let mut value = serde_yaml::from_str(text).ok()?;
    apply(&mut value, &KeyPath::default()).ok().map(|_| value)
}

fn resolve(
    value: &mut Value,
    path: &KeyPath,
    merged: &mut Vec<MergedKey>,
) -> Result<(), NoMapping> {
    match value {
        Value::Mapping(mapping) => {
            // What is merged is resolved first: it brings the keys of its own merge keys.
            for (key, below) in mapping.iter_mut() {
                if let Some(key) = key.as_str() {
                    resolve(below, &path.key(key), merged)?;
                }
            }
            if mapping.contains_key(MERGE) {
                merge(mapping, path, merged)?;
            }
            Ok(())
        }
        Value::Sequence(items) => {
            let mut items = items.iter_mut().enumerate();
            items.try_for_each(|(index, item)| resolve(item, &path.item(index), merged))
        }
        _ => Ok(()),
    }
}

/// Gives `mapping` the keys below its merge key.
fn merge(
    mapping: &mut Mapping,
    path: &KeyPath,
    merged: &mut Vec<MergedKey>,
) -> Result<(), NoMapping> {
    let at = path.key(MERGE);
    let sources: Vec<(KeyPath, Value)> = match mapping.shift_remove(MERGE) {
        Some(Value::Sequence(items)) => {
            items.into_iter().enumerate().map(|(index, item)| (at.item(index), item)).collect()
        }
        other => vec![(at, other.unwrap_or(Value::Null))],
    };
    for (at, source) in sources {
        let Value::Mapping(source) = source else { return Err((at, describe(&source))) };
        for (key, value) in source {
            if mapping.contains_key(&key) {
                continue;
            }
            if let Some(key) = key.as_str() {
                merged.push(MergedKey { present: path.key(key), written: at.key(key) });
            }
            mapping.insert(key, value);
        }
    }
    Ok(())
}

/// Where the text has `path`: through the merge keys that brought its keys.
pub(super) fn written(merged: &[MergedKey], path: &KeyPath) -> KeyPath {
    let mut path = path.clone();
    // The latest merge is the outermost: what it merged may have been merged before.
    while let Some(through) = merged.iter().rev().find_map(|key| {
        let below = path.0.strip_prefix(key.present.0.as_slice())?;
        Some(KeyPath([key.written.0.as_slice(), below].concat()))
    }) {
        path = through;
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    fn yaml(text: &str) -> Value {
        serde_yaml::from_str(text).unwrap()
    }

    #[test]
    fn own_keys_win_over_merged_ones_and_earlier_mappings_over_later_ones() {
        for (text, expected) in [
            ("{<<: {a: 1, b: 2}, b: 3}", "{b: 3, a: 1}"),
            ("{<<: [{a: 1, b: 2}, {b: 3, c: 4}], a: 5}", "{a: 5, b: 2, c: 4}"),
            (
                "{x: &x {a: 1}, y: &y {<<: *x, b: 2}, z: {<<: *y, c: 3}}",
                "{x: {a: 1}, y: {b: 2, a: 1}, z: {c: 3, b: 2, a: 1}}",
            ),
            ("[{<<: {a: {<<: {b: 1}}}}]", "[{a: {b: 1}}]"),
            ("{<<: {a: {b: 1}}, a: {c: 2}}", "{a: {c: 2}}"),
            ("{<<: []}", "{}"),
        ] {
            assert_eq!(read(text), Some(yaml(expected)), "{text}");
        }
    }

    #[test]
    fn what_is_no_mapping_is_refused_with_its_place() {
        for (text, path, found) in [
            ("a: {<<: 3}", "a.<<", "3"),
            ("a: {<<: [{b: 1}, [c]]}", "a.<<[1]", "a list of 1"),
            ("a: {<<: }", "a.<<", "nothing"),
        ] {
            let refused = apply(&mut yaml(text), &KeyPath::default()).unwrap_err();
            assert_eq!((refused.0.to_string().as_str(), refused.1.as_str()), (path, found));
        }
    }

    #[test]
    fn merged_keys_are_found_in_the_text() {
        let mut value = yaml("{x: &x {a: {k: 1}}, z: {<<: [{<<: *x, b: 2}]}}");
        let merged = apply(&mut value, &KeyPath::default()).unwrap();
        let of = |path: &str| written(&merged, &KeyPath::parse(path).unwrap()).to_string();
        assert_eq!(of("z.a.k"), "z.<<[0].<<.a.k");
        assert_eq!(of("z.b"), "z.<<[0].b");
        assert_eq!(of("x.a"), "x.a");
    }
}
