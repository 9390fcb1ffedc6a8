//! Other names of fields: short forms for `--set`, `--sweep` and the keys of `sweep:`, and former names of keys.

use super::path::{KeyPath, Step};
use serde_yaml::{Mapping, Value};

/// Short forms that paths may begin with, and the field that is meant.
const SHORT_FORMS: [(&str, &str); 1] = [("policy", "policies")];

/// Keys that were renamed: where they stand, the former name, the present name.
const RENAMED_KEYS: [(&str, &str, &str); 1] = [("policies.c", "error_m", "switch_threshold_m")];

/// A key that was read under its former name.
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
    (path, None)
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
            let rename = |(key, value)| if key == former { (Value::from(present), value) } else { (key, value) };
            *mapping = std::mem::take(mapping).into_iter().map(rename).collect::<Mapping>();
            renamed.push(RenamedKey { former: parent.key(former), present: parent.key(present) });
        }
    }
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
}
