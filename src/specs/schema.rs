//! JSON Schema of specs, for editors: derived from the types of specs, extended by what is resolved
//! before a spec is read (`extends`, names of files in place of mappings, `sweep`).

use super::experiment::spec::Experiment;
use super::sweep::series::SeriesForm;
use crate::data::import::mapped::ImportMap;
use crate::effects::Model;
use crate::plants::PlantSpec;
use schemars::{JsonSchema, generate::SchemaSettings};
use serde_json::{Map, Value, json};

/// The kinds of file that have a schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SchemaOf {
    /// An experiment.
    Experiment,
    /// A plant file.
    Plant,
    /// A model file.
    Model,
    /// A map of an import.
    Map,
}

/// The JSON Schema (draft 2020-12) of a kind of file.
pub fn schema(of: SchemaOf) -> Value {
    match of {
        SchemaOf::Model => of_type::<Model>("a model of spinebench"),
        SchemaOf::Plant => with_files(of_type::<PlantSpec>("a plant of spinebench")),
        SchemaOf::Experiment => experiment(),
        SchemaOf::Map => of_type::<ImportMap>("a map of spinebench import"),
    }
}

fn of_type<T: JsonSchema>(title: &str) -> Value {
    let schema = SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<T>();
    let mut value = schema.to_value();
    value["title"] = title.into();
    value
}

fn experiment() -> Value {
    let mut schema = with_files(of_type::<Experiment>("an experiment of spinebench"));
    // A policy from outside may stand beside the other keys of `policies`.
    schema["$defs"]["PolicyOptions"]["additionalProperties"] =
        json!({ "$ref": "#/$defs/OutsidePolicy" });
    let required = schema["required"].take();
    merging(&mut schema);
    let extends = json!({
        "type": "string",
        "description": "File in the same folder that this file extends: mappings are merged key by \
                        key, everything else is replaced.",
    });
    let sweep = json!({
        "type": ["object", "null"],
        "description": "Swept fields by their dotted paths, and the values of each; see \
                        docs/evidence/sweeps.md.",
        "additionalProperties": { "anyOf": [
            { "type": "array", "minItems": 1, "description": "The values." },
            of_form(),
            { "type": "null", "description": "Do not sweep this field, which the extended file \
                                              sweeps." },
        ]},
    });
    schema["properties"]["extends"] = extends;
    schema["properties"]["sweep"] = sweep;
    // Keys that a spec must have unless it extends another.
    schema["anyOf"] = json!([{ "required": ["extends"] }, { "required": required }]);
    if let Value::Object(schema) = &mut schema {
        schema.remove("required");
    }
    schema
}

/// The forms of swept values other than a list, without the head of their schema.
fn of_form() -> Value {
    let mut form =
        SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = true);
    form.meta_schema = None;
    form.into_generator().into_root_schema_for::<SeriesForm>().to_value()
}

/// Allows the name of a file in place of a model.
fn with_files(mut schema: Value) -> Value {
    const MODEL: &str = "#/$defs/Model";
    fn visit(value: &mut Value) {
        match value {
            Value::Object(object) if object.get("$ref").is_some_and(|to| to == MODEL) => {
                let file = json!({ "type": "string", "description": "Name of a model file." });
                object.remove("$ref");
                object.insert("anyOf".into(), json!([file, { "$ref": MODEL }]));
            }
            Value::Object(object) => object.values_mut().for_each(visit),
            Value::Array(items) => items.iter_mut().for_each(visit),
            _ => {}
        }
    }
    visit(&mut schema);
    schema
}

/// Drops `required` in everything that the root reaches through mappings alone: it is merged with
/// the extended spec, so no key is required. Items of lists must be complete, as lists are replaced
/// as a whole.
fn merging(schema: &mut Value) {
    let mut names = Vec::new();
    let mut root = schema.clone();
    loosen(&mut root, false, &mut names);
    let mut next = 0;
    while let Some(name) = names.get(next).cloned() {
        let mut definition = root["$defs"][&name].take();
        loosen(&mut definition, false, &mut names);
        root["$defs"][&name] = definition;
        next += 1;
    }
    *schema = root;
}

/// Drops `required` where mappings merge, and collects the referenced definitions; an alternative
/// keeps its name.
fn loosen(schema: &mut Value, alternative: bool, names: &mut Vec<String>) {
    let Value::Object(object) = schema else { return };
    if !alternative {
        object.remove("required");
    }
    if let Some(name) =
        object.get("$ref").and_then(Value::as_str).and_then(|to| to.strip_prefix("#/$defs/"))
        && !names.iter().any(|other| other == name)
    {
        names.push(name.to_owned());
    }
    for (key, alternatives) in [("properties", false), ("oneOf", true), ("anyOf", true)] {
        let below: Vec<&mut Value> = match object.get_mut(key) {
            Some(Value::Object(properties)) => Map::values_mut(properties).collect(),
            Some(Value::Array(items)) => items.iter_mut().collect(),
            _ => continue,
        };
        below.into_iter().for_each(|below| loosen(below, alternatives, names));
    }
    if let Some(below) = object.get_mut("additionalProperties").filter(|below| below.is_object()) {
        loosen(below, false, names);
        // An entry that is inherited is dropped by `null`.
        let entry = below.take();
        *below = json!({ "anyOf": [entry, { "type": "null" }] });
    }
}
