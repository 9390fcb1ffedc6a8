//! The nearest known key to a mistyped one.

/// The candidate with the fewest edits to `word`, if that is at most a third of its letters (and at least two), or
/// one that starts alike up to the unit at its end (`duration_ms` for `duration_s`).
pub(super) fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let allowed = (word.chars().count() / 3).max(2);
    candidates
        .into_iter()
        .map(|candidate| (edits(word, candidate), candidate))
        .filter(|&(distance, candidate)| distance <= allowed || stem(word) == stem(candidate))
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

fn stem(word: &str) -> &str {
    word.rsplit_once('_').map_or(word, |(stem, _)| stem)
}

/// Levenshtein's distance: insertions, deletions and substitutions that turn `a` into `b`.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(from != *to);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typos_units_and_strangers() {
        assert_eq!(edits("kitten", "sitting"), 3);
        assert_eq!(nearest("kernle", ["kernel", "starts"]), Some("kernel"));
        assert_eq!(nearest("duration_ms", ["points", "duration_s"]), Some("duration_s"));
        assert_eq!(nearest("banana", ["kernel", "starts"]), None);
    }
}
