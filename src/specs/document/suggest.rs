//! The nearest known key to a mistyped one.

/// The candidate with the fewest edits to `word`, at most a third of its letters (and at least
/// two), or one that differs in the unit at its end alone (`duration_ms` for `duration_s`).
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let max_edits = (word.chars().count() / 3).max(2);
    candidates
        .into_iter()
        .map(|candidate| (strsim::levenshtein(word, candidate), candidate))
        .filter(|&(distance, candidate)| distance <= max_edits || stem(word) == stem(candidate))
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

fn stem(word: &str) -> &str {
    word.rsplit_once('_').map_or(word, |(stem, _)| stem)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typos_and_wrong_units_are_matched_and_other_words_are_not() {
        assert_eq!(nearest("kernle", ["kernel", "starts"]), Some("kernel"));
        assert_eq!(nearest("duration_ms", ["points", "duration_s"]), Some("duration_s"));
        assert_eq!(nearest("banana", ["kernel", "starts"]), None);
    }
}
