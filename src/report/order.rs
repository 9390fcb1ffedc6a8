//! Values in order: each once, and the position of a name.

use super::style::{LOOKS, Look};

/// Each value once, in order of appearance.
pub(super) fn distinct<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    let mut distinct_values = Vec::new();
    for value in values {
        if !distinct_values.contains(&value) {
            distinct_values.push(value);
        }
    }
    distinct_values
}

/// Position of a name in `order`; an unknown name follows the last.
pub(super) fn rank(order: &[&str], name: &str) -> usize {
    order.iter().position(|entry| *entry == name).unwrap_or(order.len())
}

/// Kinds of training among these, the paper's first, then in order of appearance.
pub(super) fn trainings<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut kinds = distinct(names);
    kinds.sort_by_key(|name| *name != "paper");
    kinds
}

/// The last kind of training among these; empty without any.
pub(super) fn last_training<'a>(names: impl Iterator<Item = &'a str>) -> &'a str {
    trainings(names).last().copied().unwrap_or_default()
}

/// Distinct finite values, ascending.
pub(super) fn ascending(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// Names in their order, and what tables and figures call them.
pub(super) struct Labels(pub(super) &'static [(&'static str, &'static str)]);

impl Labels {
    /// Position of a name; an unknown one follows the last.
    pub(super) fn rank(&self, name: &str) -> usize {
        self.0.iter().position(|(key, _)| *key == name).unwrap_or(self.0.len())
    }

    /// The label of a name; an unknown one stands for itself.
    pub(super) fn label<'a>(&self, name: &'a str) -> &'a str {
        self.0.iter().find(|(key, _)| *key == name).map_or(name, |(_, label)| label)
    }

    /// These names, each once, in their order, unknown ones last.
    pub(super) fn sorted<'a>(&self, names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
        let mut names = distinct(names);
        names.sort_by_key(|name| self.rank(name));
        names
    }

    /// The look of a name.
    pub(super) fn look(&self, name: &str) -> Look {
        LOOKS[self.rank(name).min(LOOKS.len() - 1)]
    }
}
