//! The deserialiser's errors in the words of this project: which key, what was found, what was expected.

use super::locate::PathEnd;
use super::path::KeyPath;
use super::suggest::nearest;

/// An error taken apart.
#[derive(Debug, PartialEq)]
pub(super) struct Explanation {
    pub(super) key: KeyPath,
    pub(super) end: PathEnd,
    pub(super) found: String,
    pub(super) expected: String,
    /// For an error that was raised without its place: the text value that it is about.
    pub(super) about: Option<String>,
}

impl Explanation {
    fn new(key: KeyPath, end: PathEnd, found: String, expected: impl Into<String>) -> Explanation {
        Explanation { key, end, found, expected: expected.into(), about: None }
    }
}

/// Takes apart the message of an error that arose at the line of `path`.
pub(super) fn explain(error: &serde_yaml::Error, path: &KeyPath) -> Explanation {
    let words = error.to_string();
    let words = words.rsplit_once(" at line ").map_or(words.as_str(), |(message, _)| message);
    unknown(words, path)
        .or_else(|| missing(words, path))
        .or_else(|| mistyped(words, path))
        .or_else(|| unregistered(words, path))
        .unwrap_or_else(|| Explanation::new(path.clone(), PathEnd::Value, words.to_owned(), "a valid value"))
}

/// ``unknown kernel `x`, expected one of a, b``, as registries say it.
fn unregistered(words: &str, path: &KeyPath) -> Option<Explanation> {
    let (found, expected) = words[words.find("unknown ")?..].split_once(", expected ")?;
    let about = found.split('`').nth(1)?.to_owned();
    let near = nearest(&about, expected.trim_start_matches("one of ").split(", "));
    let hint = near.map_or(String::new(), |near| format!(" (did you mean `{near}`?)"));
    let said = Explanation::new(path.clone(), PathEnd::Value, format!("the {found}"), format!("{expected}{hint}"));
    Some(Explanation { about: Some(about), ..said })
}

/// ``unknown field `x`, expected one of `a`, `b` `` and its likes for the names of alternatives.
fn unknown(words: &str, path: &KeyPath) -> Option<Explanation> {
    let (kind, rest) = [("key", "unknown field `"), ("name", "unknown variant `")]
        .iter()
        .find_map(|(kind, start)| Some((*kind, &words[words.find(start)? + start.len()..])))?;
    let (name, rest) = rest.split_once('`')?;
    let known: Vec<&str> = rest.split('`').skip(1).step_by(2).collect();
    let listed = match known.as_slice() {
        [] => "no key here".to_owned(),
        [one] => format!("`{one}`"),
        several => format!("one of {}", several.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")),
    };
    let expected = match nearest(name, known.iter().copied()) {
        Some(near) => format!("{listed} (did you mean `{near}`?)"),
        None => listed,
    };
    // The line of an unknown name that has settings is its own, otherwise that of the key whose value it is.
    let own = path.0.last() == KeyPath::default().key(name).0.last();
    let key = if own || kind == "name" { path.clone() } else { path.key(name) };
    let end = if own || kind == "key" { PathEnd::Key } else { PathEnd::Value };
    Some(Explanation::new(key, end, format!("the unknown {kind} `{name}`"), expected))
}

/// ``missing field `x` ``.
fn missing(words: &str, path: &KeyPath) -> Option<Explanation> {
    let name = words[words.find("missing field `")?..].split('`').nth(1)?;
    Some(Explanation::new(path.key(name), PathEnd::Value, "no such key".to_owned(), format!("the key `{name}`")))
}

/// `invalid type: string "x", expected u64` and its likes.
fn mistyped(words: &str, path: &KeyPath) -> Option<Explanation> {
    let start = ["invalid type: ", "invalid value: ", "invalid length "]
        .iter()
        .find_map(|start| words.find(start).map(|at| at + start.len()))?;
    let (found, expected) = words[start..].rsplit_once(", expected ")?;
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
    let found = found.replace("unit value", "nothing").replace("string \"", "text \"").replace("map", "a mapping");
    Some(Explanation::new(path.clone(), PathEnd::Value, found, expected))
}
