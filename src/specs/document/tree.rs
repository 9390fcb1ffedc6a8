//! Operations on a tree of YAML values by key path: get, put, remove, merge.

use super::invisible;
use super::mismatch::describe;
use super::path::{KeyPath, Step};
use serde_yaml::{Mapping, Value};

/// Merges `over` into `under`: mappings key by key, everything else is replaced.
pub(super) fn merge(under: &mut Value, over: Value) {
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

/// Keys whose value is one alternative with its settings, such as `plant: {simulated: {…}}`:
/// another alternative replaces the first instead of merging with it.
pub(super) const CHOICES: [&str; 3] = ["model", "plant", "layout"];

fn other_choice(key: &Value, under: &Value, over: &Value) -> bool {
    let (Value::Mapping(under), Value::Mapping(over)) = (under, over) else { return false };
    CHOICES.iter().any(|choice| key == *choice) && over.keys().any(|name| !under.contains_key(name))
}

/// Removes the value at `path`, if there is one.
pub(crate) fn remove(value: &mut Value, path: &KeyPath) {
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
pub(crate) fn get<'a>(value: &'a Value, path: &KeyPath) -> Option<&'a Value> {
    path.0.iter().try_fold(value, |value, step| match (step, value) {
        (Step::Key(key), Value::Mapping(mapping)) => mapping.get(key.as_str()),
        (Step::Item(index), Value::Sequence(items)) => items.get(*index),
        _ => None,
    })
}

/// Sets the value of `tree` at `steps`, creating missing mappings.
pub(crate) fn put(tree: &mut Value, steps: &[Step], value: Value) -> Result<(), String> {
    let Some((step, below)) = steps.split_first() else {
        *tree = value;
        return Ok(());
    };
    if tree.is_null() && matches!(step, Step::Key(_)) {
        *tree = Value::Mapping(Mapping::new());
    }
    let next = match (tree, step) {
        (Value::Mapping(mapping), Step::Key(key)) => {
            // Another alternative replaces the present one, as it does in a file.
            let choice = CHOICES.contains(&key.as_str());
            let holder = mapping.entry(Value::from(key.as_str())).or_insert(Value::Null);
            if let (true, Some(Step::Key(name)), Value::Mapping(chosen)) =
                (choice, below.first(), &mut *holder)
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

/// The path of the first key below `path` that holds an invisible character.
pub(super) fn invisible_key(value: &Value, path: &KeyPath) -> Option<KeyPath> {
    match value {
        Value::Mapping(mapping) => mapping.iter().find_map(|(key, value)| {
            let path = path.key(key.as_str()?);
            let is_invisible = key.as_str().and_then(invisible::describe).is_some();
            if is_invisible { Some(path) } else { invisible_key(value, &path) }
        }),
        Value::Sequence(items) => items
            .iter()
            .enumerate()
            .find_map(|(index, item)| invisible_key(item, &path.item(index))),
        _ => None,
    }
}

/// The first mapping below `path` with a key that is not text, or the first tag.
pub(super) fn not_plain(value: &Value, path: &KeyPath) -> Option<(KeyPath, String)> {
    match value {
        Value::Mapping(mapping) => mapping.iter().find_map(|(key, value)| match key {
            Value::String(key) => not_plain(value, &path.key(key)),
            other => Some((path.clone(), format!("the key `{}`", describe(other)))),
        }),
        Value::Sequence(items) => {
            items.iter().enumerate().find_map(|(index, item)| not_plain(item, &path.item(index)))
        }
        Value::Tagged(tagged) => Some((path.clone(), format!("the tag `{}`", tagged.tag))),
        _ => None,
    }
}
