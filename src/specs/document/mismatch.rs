//! A value that does not have the expected type: which key, what was found, what was expected.

use super::locate::PathEnd;
use super::path::KeyPath;
use super::suggest::nearest;
use serde::de::DeserializeOwned;
use serde_path_to_error::{Deserializer, Track};
use serde_yaml::Value;
use serde_yaml::with::singleton_map_recursive;

/// Why a value cannot be read as the expected type.
#[derive(Debug, PartialEq)]
pub(crate) struct Mismatch {
    /// The path below the value that was read.
    pub(crate) key: KeyPath,
    /// Whether the key or its value is wrong.
    pub(crate) end: PathEnd,
    pub(crate) found: String,
    pub(crate) expected: String,
}

impl Mismatch {
    fn new(key: KeyPath, end: PathEnd, found: String, expected: impl Into<String>) -> Mismatch {
        Mismatch { key, end, found, expected: expected.into() }
    }
}

/// `value` as a `T`, enums as `name: settings`. `root_keys`: keys of the root besides those of `T`.
///
/// # Errors
/// [`Mismatch`] for the first key or value that does not fit.
pub(crate) fn deserialize<T: DeserializeOwned>(
    value: &Value,
    root_keys: &[&str],
) -> Result<T, Mismatch> {
    // Most values fit, and reading without a record of the path is several times faster.
    singleton_map_recursive::deserialize(value).or_else(|_| {
        let mut track = Track::new();
        singleton_map_recursive::deserialize(Deserializer::new(value, &mut track)).map_err(
            |error: serde_yaml::Error| {
                explain(&error.to_string(), &KeyPath::from(&track.path()), root_keys)
            },
        )
    })
}

/// Takes the deserialiser's message about the value at `path` apart.
fn explain(message: &str, path: &KeyPath, root_keys: &[&str]) -> Mismatch {
    unknown(message, path, root_keys)
        .or_else(|| missing(message, path))
        .or_else(|| mistyped(message, path))
        .or_else(|| unregistered(message, path))
        .unwrap_or_else(|| {
            Mismatch::new(path.clone(), PathEnd::Value, message.to_owned(), "a valid value")
        })
}

/// ``unknown kernel `x`, expected one of a, b``, the message of registries.
fn unregistered(message: &str, path: &KeyPath) -> Option<Mismatch> {
    let (found, expected) = message[message.find("unknown ")?..].split_once(", expected ")?;
    let suggestion =
        nearest(found.split('`').nth(1)?, expected.trim_start_matches("one of ").split(", "));
    let hint =
        suggestion.map_or(String::new(), |suggestion| format!(" (did you mean `{suggestion}`?)"));
    Some(Mismatch::new(
        path.clone(),
        PathEnd::Value,
        format!("the {found}"),
        format!("{expected}{hint}"),
    ))
}

/// ``unknown field `x`, expected one of `a`, `b` `` and the same for the names of enum variants.
fn unknown(message: &str, path: &KeyPath, root_keys: &[&str]) -> Option<Mismatch> {
    let (kind, rest) = [("key", "unknown field `"), ("name", "unknown variant `")]
        .iter()
        .find_map(|(kind, start)| Some((*kind, &message[message.find(start)? + start.len()..])))?;
    let (name, rest) = rest.split_once('`')?;
    let mut names: Vec<&str> = rest.split('`').skip(1).step_by(2).collect();
    if kind == "key" && path.0.len() == 1 {
        names.extend(root_keys);
    }
    let expected = if names.is_empty() { "no key here".to_owned() } else { one_near(&names, name) };
    // A variant without settings is a value, not a key.
    let is_key = path.0.last() == KeyPath::default().key(name).0.last();
    let end = if is_key { PathEnd::Key } else { PathEnd::Value };
    Some(Mismatch::new(path.clone(), end, format!("the unknown {kind} `{name}`"), expected))
}

/// ``missing field `x` ``.
fn missing(message: &str, path: &KeyPath) -> Option<Mismatch> {
    let name = message[message.find("missing field `")?..].split('`').nth(1)?;
    Some(Mismatch::new(
        path.key(name),
        PathEnd::Value,
        "no such key".to_owned(),
        format!("the key `{name}`"),
    ))
}

/// `invalid type: string "x", expected u64` and similar messages.
fn mistyped(message: &str, path: &KeyPath) -> Option<Mismatch> {
    let start = ["invalid type: ", "invalid value: ", "invalid length "]
        .iter()
        .find_map(|start| message.find(start).map(|at| at + start.len()))?;
    let (found, expected) = message[start..].rsplit_once(", expected ")?;
    let expected = match expected {
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number, 0 or more",
        "i8" | "i16" | "i32" | "i64" | "isize" => "a whole number",
        "f32" | "f64" => "a number",
        "a boolean" => "true or false",
        "a string" => "text",
        "a sequence" => "a list",
        other if other.starts_with("enum ") => "one alternative with its settings",
        other if other.starts_with("struct ") || other == "a map" => "a mapping of keys to values",
        other => other,
    };
    let found = found
        .replace("unit value", "nothing")
        .replace("string \"", "text \"")
        .replace("map", "a mapping");
    Some(Mismatch::new(path.clone(), PathEnd::Value, found, expected))
}

/// Letters of a text that error messages show at most.
const MAX_SHOWN: usize = 60;

/// A value as error messages show it.
pub(crate) fn describe(value: &Value) -> String {
    match value {
        Value::Null => "nothing".to_owned(),
        Value::Bool(flag) => flag.to_string(),
        Value::Number(number) => number.to_string(),
        Value::String(text) => match text.lines().next() {
            Some(line) if line.len() < text.len() || line.chars().count() > MAX_SHOWN => {
                format!(
                    "a text that begins with `{}`",
                    line.chars().take(MAX_SHOWN).collect::<String>()
                )
            }
            _ => format!("`{text}`"),
        },
        Value::Sequence(items) if items.is_empty() => "an empty list".to_owned(),
        Value::Sequence(items) => format!("a list of {}", items.len()),
        Value::Mapping(_) => "a mapping".to_owned(),
        Value::Tagged(tagged) => format!("the tag `{}`", tagged.tag),
    }
}

/// ``one of `a`, `b` ``.
pub(crate) fn one_of(names: &[&str]) -> String {
    let listed: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    let listed = listed.join(", ");
    if names.len() == 1 { listed } else { format!("one of {listed}") }
}

/// The same with the name that is most like the one that was found.
pub(crate) fn one_near(names: &[&str], found: &str) -> String {
    match nearest(found, names.iter().copied()) {
        Some(suggestion) => format!("{} (did you mean `{suggestion}`?)", one_of(names)),
        None => one_of(names),
    }
}
