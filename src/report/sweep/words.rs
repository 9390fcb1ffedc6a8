//! Keys of specs and their values in words, for axes.

/// What a swept key sets, by the end of its path.
const KEYS: [(&str, &str); 15] = [
    ("gp.kernel", "kernel"),
    ("gp.selection", "selection of points"),
    ("gp_points.p_sim", "simulated tip from"),
    ("gp_points", "real points"),
    ("explore.points", "simulated samples"),
    ("explore.max_step", "largest step"),
    ("control", "control rate"),
    ("network.hidden", "hidden units"),
    ("network.kind", "network"),
    ("network.members", "networks averaged"),
    ("network.optimiser", "optimiser"),
    ("switch_threshold", "threshold of policy C"),
    ("simulated.noise", "tracking noise"),
    ("model.effects", "missing effects"),
    ("plant", "“real” robot"),
];

/// Values that are abbreviations or names.
const VALUES: [(&str, &str); 13] = [
    ("se_ard[tendons]", "SE (tendons)"),
    ("se_ard[place]", "SE (place)"),
    ("se_ard", "SE (ARD)"),
    ("se_iso", "SE (isotropic)"),
    ("matern12", "Matérn 1/2"),
    ("matern32", "Matérn 3/2"),
    ("matern52", "Matérn 5/2"),
    ("adam", "Adam"),
    ("lbfgs", "L-BFGS"),
    ("elman", "Elman"),
    ("gru", "GRU"),
    ("lstm", "LSTM"),
    ("k_means", "k-means"),
];

/// The key in words; `None` of one that nobody gave any.
pub(super) fn key_words(key: &str) -> Option<&'static str> {
    let is_end = |end: &str| {
        key.strip_suffix(end).is_some_and(|head| head.is_empty() || head.ends_with('.'))
    };
    KEYS.iter().find(|(end, _)| is_end(end)).map(|(_, words)| *words)
}

/// A value in words: of a sum of kernels each of them; paths and data stay as they are.
pub(super) fn value_words(value: &str) -> String {
    if value.contains(['/', '{', '"']) {
        return value.to_owned();
    }
    let part = |part: &str| {
        let known = VALUES.iter().find(|(name, _)| *name == part);
        known.map_or_else(|| part.replace('_', " "), |(_, words)| (*words).to_owned())
    };
    value.split(" + ").map(part).collect::<Vec<_>>().join(" + ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_and_values_have_words() {
        assert_eq!(key_words("policies.c.switch_threshold"), Some("threshold of policy C"));
        assert_eq!(key_words("a.my_gp_points"), None);
        assert_eq!(value_words("se_ard[tendons] + linear"), "SE (tendons) + linear");
        assert_eq!(value_words("../models/my_robot"), "../models/my_robot");
    }
}
