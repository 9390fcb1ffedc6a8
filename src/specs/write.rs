//! Values written as YAML, in the form in which specs are read.

use super::document::merge_keys;
use super::document::mismatch::deserialize;
use crate::effects::{EffectSpec, Model};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// A value as YAML in the form in which specs are read.
///
/// # Errors
/// The serialiser's message for a type that YAML cannot represent.
pub fn to_yaml<T: Serialize>(value: &T) -> Result<String, String> {
    yaml_text(value).map_err(|error| error.to_string())
}

fn yaml_text<T: Serialize>(value: &T) -> Result<String, serde_yaml::Error> {
    let mut text = Vec::new();
    serde_yaml::with::singleton_map_recursive::serialize(
        value,
        &mut serde_yaml::Serializer::new(&mut text),
    )?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}

/// The text of a model file, with effects as `- name: {…}`.
///
/// # Errors
/// When a number cannot be written as YAML.
pub fn model_text(model: &Model) -> Result<String, serde_yaml::Error> {
    yaml_text(model)
}

/// The text `written` of a model file with the last `added` effects of `model` appended to its own, which keeps
/// comments and layout. When that does not read back as `model`, the whole model written anew.
///
/// # Errors
/// As [`model_text`].
pub fn extended_text(
    written: &str,
    model: &Model,
    added: usize,
) -> Result<String, serde_yaml::Error> {
    let line = |effect: &EffectSpec| -> Result<String, serde_yaml::Error> {
        let name = effect.card().name;
        let value = serde_json::to_value(effect)
            .map_err(<serde_yaml::Error as serde::ser::Error>::custom)?;
        let fields = value[name].to_string().replace('"', "").replace(':', ": ").replace(',', ", ");
        Ok(format!("  - {name}: {fields}\n"))
    };
    let lines: String =
        model.effects[model.effects.len() - added..].iter().map(line).collect::<Result<_, _>>()?;
    let extended = with_effects(written, &lines);
    let reads_back = |text: &String| {
        let value = merge_keys::read(text);
        value
            .and_then(|value| deserialize::<Model>(&value, &[]).ok())
            .is_some_and(|read| read == *model)
    };
    extended.filter(reads_back).map_or_else(|| model_text(model), Ok)
}

/// `written` with `lines` after its last effect, where effects are a list of lines.
fn with_effects(written: &str, lines: &str) -> Option<String> {
    let mut text = written.to_owned();
    if !text.ends_with('\n') {
        text.push('\n');
    }
    let Some(start) = text.lines().position(|line| line.starts_with("effects:")) else {
        return Some(format!("{text}effects:\n{lines}"));
    };
    let head: String = text.lines().take(start).map(|line| format!("{line}\n")).collect();
    let (effects_line, below) = text
        .lines()
        .skip(start)
        .collect::<Vec<_>>()
        .split_first()
        .map(|(a, b)| (*a, b.to_vec()))?;
    let comment = effects_line
        .split_once('#')
        .map_or_else(String::new, |(_, comment)| format!("  # {}", comment.trim()));
    if effects_line["effects:".len()..].trim_start().starts_with("[]") {
        let below: String = below.iter().map(|line| format!("{line}\n")).collect();
        return Some(format!("{head}effects:{comment}\n{lines}{below}"));
    }
    // The list ends where the next key of the model begins.
    let next =
        below.iter().position(|line| line.starts_with(char::is_alphabetic)).unwrap_or(below.len());
    let joined = |lines: &[&str]| lines.iter().map(|line| format!("{line}\n")).collect::<String>();
    Some(format!(
        "{head}{effects_line}\n{}{lines}{}",
        joined(&below[..next]),
        joined(&below[next..])
    ))
}

/// Keys of the root in which two specs in YAML differ; none where one cannot be read.
pub fn differing_keys(one: &str, other: &str) -> Vec<String> {
    let read = |text: &str| serde_yaml::from_str::<BTreeMap<String, serde_yaml::Value>>(text).ok();
    let (Some(one), Some(other)) = (read(one), read(other)) else { return Vec::new() };
    let all: BTreeSet<&String> = one.keys().chain(other.keys()).collect();
    all.into_iter().filter(|key| one.get(*key) != other.get(*key)).cloned().collect()
}

#[cfg(test)]
mod tests {
    use super::with_effects;

    #[test]
    fn effects_are_added_to_their_list_wherever_it_stands() {
        let lines = "  - tip_load: {mass_kg: 0.02}\n";
        for (written, expected) in [
            ("robot: {}\n", "robot: {}\neffects:\n  - tip_load: {mass_kg: 0.02}\n"),
            (
                "effects: []  # none\nrobot: {}\n",
                "effects:  # none\n  - tip_load: {mass_kg: 0.02}\nrobot: {}\n",
            ),
            (
                "effects:\n  - delay: {time_s: 0.1}\n# points\ntracking: {}\n",
                "effects:\n  - delay: {time_s: 0.1}\n# points\n  - tip_load: {mass_kg: \
                 0.02}\ntracking: {}\n",
            ),
        ] {
            assert_eq!(with_effects(written, lines).as_deref(), Some(expected));
        }
    }
}
