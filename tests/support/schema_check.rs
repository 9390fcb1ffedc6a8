//! A checker of JSON against the part of JSON Schema that our schemas use. What it does not know it
//! refuses to pass over.

use serde_json::{Map, Value};

/// Words about a schema that ask nothing of a value.
const SILENT: [&str; 7] = ["$schema", "$defs", "title", "description", "default", "format", "$ref"];

/// What is wrong with `value`, each with its path.
pub(crate) fn problems(schema: &Value, value: &Value) -> Vec<String> {
    let mut found = Vec::new();
    check(schema, schema, value, "", &mut found);
    found
}

fn fits(root: &Value, schema: &Value, value: &Value) -> bool {
    let mut found = Vec::new();
    check(root, schema, value, "", &mut found);
    found.is_empty()
}

fn check(root: &Value, schema: &Value, value: &Value, path: &str, found: &mut Vec<String>) {
    let rules: &Map<String, Value> = match schema {
        Value::Object(rules) => rules,
        Value::Bool(true) => return,
        _ => return found.push(format!("{path}: nothing fits")),
    };
    if let Some(to) = rules.get("$ref").and_then(Value::as_str) {
        let target = to.strip_prefix('#').and_then(|pointer| root.pointer(pointer));
        check(root, target.unwrap_or_else(|| panic!("{to} leads nowhere")), value, path, found);
    }
    for (rule, asked) in rules.iter().filter(|(rule, _)| !SILENT.contains(&rule.as_str())) {
        let list = || asked.as_array().unwrap().iter();
        let good = match rule.as_str() {
            "type" => match asked {
                Value::Array(kinds) => kinds.iter().any(|kind| is(kind.as_str().unwrap(), value)),
                kind => is(kind.as_str().unwrap(), value),
            },
            "const" => asked == value,
            "enum" => list().any(|one| one == value),
            "pattern" => matches(asked, value),
            "anyOf" => list().any(|one| fits(root, one, value)),
            "oneOf" => list().filter(|one| fits(root, one, value)).count() == 1,
            "minimum" => value.as_f64().is_none_or(|number| number >= asked.as_f64().unwrap()),
            "maximum" => value.as_f64().is_none_or(|number| number <= asked.as_f64().unwrap()),
            "minItems" => {
                value.as_array().is_none_or(|items| items.len() as u64 >= asked.as_u64().unwrap())
            }
            "maxItems" => {
                value.as_array().is_none_or(|items| items.len() as u64 <= asked.as_u64().unwrap())
            }
            "required" => value
                .as_object()
                .is_none_or(|has| list().all(|key| has.contains_key(key.as_str().unwrap()))),
            "items" => {
                for (index, item) in value.as_array().into_iter().flatten().enumerate() {
                    check(root, asked, item, &format!("{path}[{index}]"), found);
                }
                true
            }
            "prefixItems" => {
                for (index, (item, asked)) in
                    value.as_array().into_iter().flatten().zip(list()).enumerate()
                {
                    check(root, asked, item, &format!("{path}[{index}]"), found);
                }
                true
            }
            "properties" => {
                for (key, asked) in asked.as_object().unwrap() {
                    if let Some(value) = value.get(key) {
                        check(root, asked, value, &format!("{path}.{key}"), found);
                    }
                }
                true
            }
            "additionalProperties" => {
                let known = rules.get("properties").and_then(Value::as_object);
                let more = value.as_object().into_iter().flatten();
                for (key, value) in
                    more.filter(|(key, _)| known.is_none_or(|known| !known.contains_key(*key)))
                {
                    check(root, asked, value, &format!("{path}.{key}"), found);
                }
                true
            }
            other => panic!("the checker does not know `{other}`"),
        };
        if !good {
            found.push(format!("{path}: {value} against {rule}"));
        }
    }
}

/// Whether a text matches a pattern; what is no text is not asked.
fn matches(pattern: &Value, value: &Value) -> bool {
    let pattern = regex::Regex::new(pattern.as_str().unwrap()).unwrap();
    value.as_str().is_none_or(|text| pattern.is_match(text))
}

fn is(kind: &str, value: &Value) -> bool {
    match kind {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        "number" => value.is_number(),
        "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
        other => panic!("the checker does not know the type `{other}`"),
    }
}
