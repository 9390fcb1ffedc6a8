//! The values of keys that an expected range names: "at most `max_pull_m`" is no help without the
//! number.

use crate::specs::document::path::{KeyPath, Step};
use crate::specs::document::tree::get;
use serde::Serialize;
use serde_yaml::Value;

/// `expected` with the value behind each `` `key` `` that stands beside the key at `path`, or
/// beside one above it.
pub(super) fn with_values<T: Serialize>(expected: &str, settings: &T, path: &KeyPath) -> String {
    if !expected.contains('`') {
        return expected.to_owned();
    }
    let tree = serde_yaml::with::singleton_map_recursive::serialize(
        settings,
        serde_yaml::value::Serializer,
    );
    let tree = tree.unwrap_or_default();
    let mut words = String::new();
    for (index, part) in expected.split('`').enumerate() {
        if index % 2 == 0 {
            words.push_str(part);
            continue;
        }
        words.push_str(&format!("`{part}`"));
        if let Some(value) = beside(&tree, path, part) {
            words.push_str(&format!(" ({value})"));
        }
    }
    words
}

/// The number under `key` in the nearest mapping at or above `path`.
fn beside(tree: &Value, path: &KeyPath, key: &str) -> Option<String> {
    let named = |depth: usize| KeyPath([&path.0[..depth], &[Step::Key(key.to_owned())]].concat());
    let value = (0..=path.0.len()).rev().find_map(|depth| get(tree, &named(depth)))?;
    match value {
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_named_key_is_told_with_its_number() {
        let settings =
            json!({ "explore": { "max_pull_m": 0.03, "max_step_m": 0.05 }, "name": "x" });
        let path = KeyPath::parse("explore.max_step_m").unwrap();
        assert_eq!(
            with_values("at most `max_pull_m`", &settings, &path),
            "at most `max_pull_m` (0.03)"
        );
        assert_eq!(
            with_values("below `other`, not `name`", &settings, &path),
            "below `other`, not `name`"
        );
    }
}
