//! Other names of fields, for `--set`, `--sweep` and the keys of `sweep:`.

use super::path::{KeyPath, Step};

/// Aliases and the fields that they stand for, applied in order.
pub(in crate::specs) const ALIASES: [(&str, &str); 2] = [
    ("policy", "policies"),
    // The error at which policy C changes controllers: the paper's e_c (section IV-F).
    ("policies.c.switch_threshold_m", "policies.c.error_m"),
];

/// `path` with every alias replaced by the field that it stands for.
pub(in crate::specs) fn canonical(mut path: KeyPath) -> KeyPath {
    for (alias, name) in ALIASES {
        let keys = |text: &str| -> Vec<Step> { text.split('.').map(|key| Step::Key(key.to_owned())).collect() };
        if let Some(below) = path.0.strip_prefix(keys(alias).as_slice()) {
            path = KeyPath([keys(name).as_slice(), below].concat());
        }
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_words_lead_to_our_fields() {
        let of = |text: &str| canonical(KeyPath::parse(text).unwrap()).to_string();
        assert_eq!(of("policy.c.switch_threshold_m"), "policies.c.error_m");
        assert_eq!(of("policies.c.switch_threshold_m"), "policies.c.error_m");
        assert_eq!(of("policy.a.tolerance_m"), "policies.a.tolerance_m");
        assert_eq!(of("gp.kernel"), "gp.kernel");
    }
}
