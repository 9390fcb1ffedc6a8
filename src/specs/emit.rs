//! A document written so that each line belongs to one key path: the map from the parser's line numbers back to keys.

use super::path::KeyPath;
use serde_yaml::Value;

/// A document in JSON-like flow style, one key or item a line, and the path that each line stands for.
pub(super) struct Emitted {
    /// The text; its values equal those of the document.
    pub(super) text: String,
    /// Path of each line, from the first.
    pub(super) paths: Vec<KeyPath>,
}

/// Writes `value`. A key that is not text, or a tagged value, is returned as an error with its path.
///
/// # Errors
/// The path and a description of what JSON-like text cannot hold.
pub(super) fn emit(value: &Value) -> Result<Emitted, (KeyPath, String)> {
    let mut out = Emitted { text: String::new(), paths: Vec::new() };
    out.value(value, &KeyPath::default(), "", "")?;
    Ok(out)
}

impl Emitted {
    fn line(&mut self, path: &KeyPath, text: &str) {
        self.text.push_str(text);
        self.text.push('\n');
        self.paths.push(path.clone());
    }

    fn value(&mut self, value: &Value, path: &KeyPath, head: &str, tail: &str) -> Result<(), (KeyPath, String)> {
        let scalar = match value {
            Value::Mapping(mapping) => {
                self.line(path, &format!("{head}{{"));
                for (key, value) in mapping {
                    let Value::String(key) = key else {
                        return Err((path.clone(), format!("the key `{}`", describe(key))));
                    };
                    self.value(value, &path.key(key), &format!("{}: ", quoted(key)), ",")?;
                }
                self.line(path, &format!("}}{tail}"));
                return Ok(());
            }
            Value::Sequence(items) => {
                self.line(path, &format!("{head}["));
                for (index, item) in items.iter().enumerate() {
                    self.value(item, &path.item(index), "", ",")?;
                }
                self.line(path, &format!("]{tail}"));
                return Ok(());
            }
            Value::Tagged(tagged) => return Err((path.clone(), format!("the tag `{}`", tagged.tag))),
            Value::Null => "null".to_owned(),
            Value::Bool(flag) => flag.to_string(),
            Value::Number(number) => number.to_string(),
            Value::String(text) => quoted(text),
        };
        self.line(path, &format!("{head}{scalar}{tail}"));
        Ok(())
    }
}

/// A double-quoted scalar, which YAML reads as JSON does.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// A value in the words of an error message.
pub(super) fn describe(value: &Value) -> String {
    match value {
        Value::Null => "nothing".to_owned(),
        Value::Bool(flag) => flag.to_string(),
        Value::Number(number) => number.to_string(),
        Value::String(text) => format!("`{text}`"),
        Value::Sequence(items) if items.is_empty() => "an empty list".to_owned(),
        Value::Sequence(items) => format!("a list of {}", items.len()),
        Value::Mapping(_) => "a mapping".to_owned(),
        Value::Tagged(tagged) => format!("the tag `{}`", tagged.tag),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_holds_the_same_values_and_each_line_its_path() {
        let value: Value =
            serde_yaml::from_str("a: {b: [1, 2.5e-9, .inf], 'c d': \"x\\\"y\"}\ne: ~\nf: '12'\n").unwrap();
        let out = emit(&value).unwrap();
        assert_eq!(serde_yaml::from_str::<Value>(&out.text).unwrap(), value);
        let line = out.text.lines().position(|line| line.contains("2.5e-9")).unwrap();
        assert_eq!(out.paths[line].to_string(), "a.b[1]");
        assert_eq!(out.paths.len(), out.text.lines().count());
    }
}
