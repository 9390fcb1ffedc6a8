//! Other names of fields: short forms for `--set`, `--sweep` and the keys of `sweep:`, and former
//! names of keys.

use super::path::{KeyPath, Step};
use crate::policies::OUTSIDE_KINDS;
use serde_yaml::{Mapping, Value};

/// Short forms that paths may begin with, and the field that is meant.
const SHORT_FORMS: [(&str, &str); 1] = [("policy", "policies")];

/// Keys that were renamed: where they stand, the former name, the present name.
const RENAMED_KEYS: [(&str, &str, &str); 1] = [("policies.c", "error_m", "switch_threshold_m")];

/// Where policies from outside stand; a spec may leave the last key out.
const OUTSIDE: [&str; 2] = ["policies", "outside"];

/// A key that was read under another name, a former or a short one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct RenamedKey {
    /// The path as it was written.
    pub(super) former: KeyPath,
    /// The path that is meant.
    pub(super) present: KeyPath,
}

fn keys(path: &str) -> Vec<Step> {
    path.split('.').map(|key| Step::Key(key.to_owned())).collect()
}

/// The path of the field that `path` means, and the renaming if it has a former name in it.
pub(super) fn canonical(mut path: KeyPath) -> (KeyPath, Option<RenamedKey>) {
    for (short, name) in SHORT_FORMS {
        if let Some(below) = path.0.strip_prefix(keys(short).as_slice()) {
            path = KeyPath([keys(name).as_slice(), below].concat());
        }
    }
    for (parent, former, present) in RENAMED_KEYS {
        let [former, present] = [former, present].map(|key| [keys(parent), keys(key)].concat());
        if let Some(below) = path.0.strip_prefix(former.as_slice()) {
            path = KeyPath([present.as_slice(), below].concat());
            return (path, Some(RenamedKey { former: KeyPath(former), present: KeyPath(present) }));
        }
    }
    if let [Step::Key(first), Step::Key(name), Step::Key(kind), ..] = path.0.as_slice()
        && first == OUTSIDE[0]
        && name != OUTSIDE[1]
        && OUTSIDE_KINDS.contains(&kind.as_str())
    {
        path.0.insert(1, Step::Key(OUTSIDE[1].to_owned()));
    }
    (path, None)
}

impl RenamedKey {
    /// Whether the user should know of it: a short form is none of the former names.
    pub(super) fn is_former(&self) -> bool {
        !self.present.0.starts_with(&OUTSIDE.map(|key| Step::Key(key.to_owned())))
    }
}

/// Takes policies from outside that stand among the keys of `policies` to their place.
fn move_outside(value: &mut Value, root: &KeyPath) -> Vec<RenamedKey> {
    let policies = KeyPath::default().key(OUTSIDE[0]);
    let holder = match root.0.as_slice() {
        [] => value.get_mut(OUTSIDE[0]),
        _ if *root == policies => Some(value),
        _ => None,
    };
    let Some(Value::Mapping(mapping)) = holder else { return Vec::new() };
    let is_outside = |policy: &Value| {
        let keys = policy
            .as_mapping()
            .filter(|mapping| mapping.len() == 1)
            .and_then(|mapping| mapping.keys().next());
        keys.and_then(Value::as_str).is_some_and(|kind| OUTSIDE_KINDS.contains(&kind))
    };
    let named = mapping
        .iter()
        .filter(|(name, policy)| name.as_str() != Some(OUTSIDE[1]) && is_outside(policy));
    let names: Vec<String> =
        named.filter_map(|(name, _)| name.as_str().map(str::to_owned)).collect();
    let mut renamed = Vec::new();
    for name in names {
        let Some(policy) = mapping.remove(name.as_str()) else { continue };
        let outside =
            mapping.entry(OUTSIDE[1].into()).or_insert_with(|| Value::Mapping(Mapping::new()));
        if let Value::Mapping(outside) = outside {
            outside.insert(name.as_str().into(), policy);
        }
        renamed.push(RenamedKey {
            former: policies.key(&name),
            present: policies.key(OUTSIDE[1]).key(&name),
        });
    }
    renamed
}

/// Makes the names of files of policies from outside, which are relative to `folder`, absolute: the
/// resolved spec lies elsewhere.
pub(super) fn resolve_outside(value: &mut Value, folder: &std::path::Path) {
    let Some(Value::Mapping(outside)) =
        value.get_mut(OUTSIDE[0]).and_then(|policies| policies.get_mut(OUTSIDE[1]))
    else {
        return;
    };
    for (_, policy) in outside.iter_mut() {
        for kind in OUTSIDE_KINDS {
            if let Some(Value::String(file)) =
                policy.get_mut(kind).and_then(|options| options.get_mut("file"))
            {
                let place = folder.join(&*file);
                *file = std::path::absolute(&place).unwrap_or(place).display().to_string();
            }
        }
    }
}

/// Gives the keys of `value`, which stands at `root`, their present names.
///
/// # Errors
/// The former path of a key that stands there under both names.
pub(super) fn rename_keys(value: &mut Value, root: &KeyPath) -> Result<Vec<RenamedKey>, KeyPath> {
    let mut renamed = Vec::new();
    for (parent, former, present) in RENAMED_KEYS {
        let parent = KeyPath(keys(parent));
        let Some(below) = parent.0.strip_prefix(root.0.as_slice()) else { continue };
        let holder = below.iter().try_fold(&mut *value, |value, step| match step {
            Step::Key(key) => value.get_mut(key.as_str()),
            Step::Item(_) => None,
        });
        let Some(Value::Mapping(mapping)) = holder else { continue };
        if mapping.contains_key(former) {
            if mapping.contains_key(present) {
                return Err(parent.key(former));
            }
            let rename = |(key, value)| {
                if key == former { (Value::from(present), value) } else { (key, value) }
            };
            *mapping = std::mem::take(mapping).into_iter().map(rename).collect::<Mapping>();
            renamed.push(RenamedKey { former: parent.key(former), present: parent.key(present) });
        }
    }
    renamed.extend(move_outside(value, root));
    Ok(renamed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_forms_and_former_names_lead_to_present_fields() {
        let of = |text: &str| canonical(KeyPath::parse(text).unwrap()).0.to_string();
        assert_eq!(of("policy.c.switch_threshold_m"), "policies.c.switch_threshold_m");
        assert_eq!(of("policies.c.error_m"), "policies.c.switch_threshold_m");
        assert_eq!(of("policy.c.error_m"), "policies.c.switch_threshold_m");
        assert_eq!(of("policy.a.tolerance_m"), "policies.a.tolerance_m");
        assert_eq!(of("gp.kernel"), "gp.kernel");
    }

    #[test]
    fn a_former_key_is_renamed_in_place_and_refused_beside_the_present_one() {
        let yaml = |text: &str| serde_yaml::from_str::<Value>(text).unwrap();
        let mut value = yaml("{rest_m: 1, error_m: 2}");
        let root = KeyPath::parse("policies.c").unwrap();
        assert_eq!(rename_keys(&mut value, &root).unwrap().len(), 1);
        assert_eq!(value, yaml("{rest_m: 1, switch_threshold_m: 2}"));
        let mut both = yaml("{policies: {c: {error_m: 1, switch_threshold_m: 2}}}");
        assert_eq!(rename_keys(&mut both, &KeyPath::default()), Err(root.key("error_m")));
    }

    #[test]
    fn a_policy_from_outside_is_taken_to_its_place() {
        let of = |path: &str| canonical(KeyPath::parse(path).unwrap()).0.to_string();
        let yaml = |text: &str| serde_yaml::from_str::<Value>(text).unwrap();
        assert_eq!(of("policies.mine.onnx.file"), "policies.outside.mine.onnx.file");
        assert_eq!(of("policies.outside.mine.onnx.file"), "policies.outside.mine.onnx.file");
        let mut value = yaml("{policies: {c: {dwell: 1}, mine: {onnx: {file: mine.onnx}}}}");
        let renamed = rename_keys(&mut value, &KeyPath::default()).unwrap();
        assert_eq!(
            value,
            yaml("{policies: {c: {dwell: 1}, outside: {mine: {onnx: {file: mine.onnx}}}}}")
        );
        assert_eq!(renamed[0].former.to_string(), "policies.mine");
        assert!(!renamed[0].is_former());
        resolve_outside(&mut value, std::path::Path::new("/specs"));
        assert_eq!(value["policies"]["outside"]["mine"]["onnx"]["file"], "/specs/mine.onnx");
    }
}
