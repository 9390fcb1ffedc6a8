//! What a spec inherits beside what it writes: mappings merge, and every kind of training runs.

use super::layer::Layer;
use super::locate::PathEnd;
use super::path::KeyPath;
use super::tree::get;
use serde_yaml::Value;

/// The mapping of which every entry runs, whoever wrote it.
const MAPPING: &str = "training";

/// A note where the strongest source of `training` names some kinds, and others are inherited.
pub(super) fn note(layers: &[Layer], merged: &Value) -> Option<String> {
    let path = KeyPath::default().key(MAPPING);
    let names = |value: &Value| -> Vec<String> {
        let keys = value.as_mapping().into_iter().flatten();
        keys.filter_map(|(key, _)| key.as_str().map(str::to_owned)).collect()
    };
    let kept = |name: &String| get(merged, &path.key(name)).is_some_and(|value| !value.is_null());
    let (layer, written) = layers.iter().find_map(|layer| Some((layer, layer.get(&path)?)))?;
    let written = names(&written);
    let inherited: Vec<String> = names(get(merged, &path)?)
        .into_iter()
        .filter(|name| !written.contains(name) && kept(name))
        .collect();
    if inherited.is_empty() || !written.iter().any(kept) {
        return None;
    }
    let place = layer.place(&path, PathEnd::Key);
    let null = inherited.iter().map(|name| format!("{name}: null")).collect::<Vec<_>>().join(", ");
    let inherited = inherited.join("`, `");
    Some(format!(
        "{place}: {MAPPING}: runs the inherited `{inherited}` too; `{MAPPING}: {{{null}}}` drops it"
    ))
}
