//! The keys of a kind of file as a table, from its JSON Schema.

use serde_json::Value;

use super::markup::MarkdownTable;

/// Keys deeper than this are left to the schema itself.
const MAX_DEPTH: usize = 3;

/// A line for each key of a schema: its path, its type, what it defaults to and what it says.
pub fn keys_table(schema: &Value) -> String {
    let mut rows = Vec::new();
    add(schema, schema, "", 1, &mut rows);
    MarkdownTable::new("key | type | default | meaning", rows.into_iter()).markdown()
}

/// The schema behind references, and behind the alternative that is not `null`.
fn resolved<'a>(root: &'a Value, schema: &'a Value) -> &'a Value {
    if let Some(place) = schema["$ref"].as_str().and_then(|place| place.strip_prefix('#')) {
        return root.pointer(place).map_or(schema, |schema| resolved(root, schema));
    }
    let [only] = schema["allOf"].as_array().map_or(&[][..], Vec::as_slice) else {
        let some = schema["anyOf"].as_array().into_iter().flatten();
        let mut some = some.filter(|schema| schema["type"] != "null");
        return match (some.next(), some.next()) {
            (Some(only), None) => resolved(root, only),
            _ => schema,
        };
    };
    resolved(root, only)
}

fn add(root: &Value, schema: &Value, above: &str, depth: usize, rows: &mut Vec<Vec<String>>) {
    let properties = resolved(root, schema)["properties"].as_object();
    for (name, property) in properties.into_iter().flatten() {
        let path = if above.is_empty() { name.clone() } else { format!("{above}.{name}") };
        let inner = resolved(root, property);
        let said = [property, inner].into_iter().find_map(|schema| schema["description"].as_str());
        let said = said.unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ");
        let default = match &property["default"] {
            Value::Null | Value::Object(_) | Value::Array(_) => String::new(),
            value => format!("`{}`", value.to_string().trim_matches('"')),
        };
        rows.push(vec![format!("`{path}`"), type_words(inner), default, said.replace('|', "\\|")]);
        if depth < MAX_DEPTH {
            add(root, inner, &path, depth + 1, rows);
        }
    }
}

/// The type of a value in a word or two.
fn type_words(schema: &Value) -> String {
    let one = |schema: &Value| match schema["type"].as_str() {
        Some(name) => Some(name.to_owned()),
        None => schema["type"].as_array().map(|names| {
            let names = names.iter().filter_map(Value::as_str).filter(|name| *name != "null");
            names.collect::<Vec<_>>().join(" or ")
        }),
    };
    if let Some(names) = schema["enum"].as_array() {
        let names: Vec<String> =
            names.iter().filter_map(Value::as_str).map(|name| format!("`{name}`")).collect();
        return names.join(", ");
    }
    one(schema).unwrap_or_else(|| "one of several".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_listed_with_those_below_them() {
        let schema = serde_json::json!({
            "properties": {
                "robot": {"$ref": "#/$defs/Robot"},
                "seeds": {"type": ["integer", "null"], "default": 10, "description": "How\nmany."}
            },
            "$defs": {"Robot": {"type": "object", "description": "A robot.", "properties": {
                "kind": {"enum": ["a", "b"]}
            }}}
        });
        let table = keys_table(&schema);
        for line in [
            "| `robot` | object |  | A robot. |",
            "| `robot.kind` | `a`, `b` |  |  |",
            "| `seeds` | integer | `10` | How many. |",
        ] {
            assert!(table.contains(line), "{table}");
        }
    }
}
