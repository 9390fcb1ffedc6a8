//! Values in order: each once, and the position of a name.

/// Each value once, in order of appearance.
pub(super) fn distinct<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    let mut found = Vec::new();
    for value in values {
        if !found.contains(&value) {
            found.push(value);
        }
    }
    found
}

/// Position of a name in `order`; an unknown name follows the last.
pub(super) fn rank(order: &[&str], name: &str) -> usize {
    order.iter().position(|known| *known == name).unwrap_or(order.len())
}

/// Kinds of training among these, the paper's first, then in order of appearance.
pub(super) fn trainings<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut found = distinct(names);
    found.sort_by_key(|name| *name != "paper");
    found
}
