//! Published results in a text: a table or figure is inserted between two markers, so that a README
//! shows the published numbers without copying by hand.

/// Why a table or figure could not be inserted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PageError {
    /// A marker is missing.
    #[error("found no line `{marker}`, expected one")]
    NoMarker {
        /// The expected line.
        marker: String,
    },
    /// The end precedes the beginning, or a marker occurs twice.
    #[error("found `{marker}` at a wrong place, expected one `begin` followed by one `end`")]
    OutOfPlace {
        /// The line that is out of place.
        marker: String,
    },
}

/// `text` with everything between the lines `<!-- begin:NAME -->` and `<!-- end:NAME -->` replaced
/// by `content`. The markers are kept, so a second call changes nothing.
///
/// # Errors
/// [`PageError`] when a marker is missing, occurs twice or is out of order.
pub fn splice(text: &str, name: &str, content: &str) -> Result<String, PageError> {
    let (begin, end) = (format!("<!-- begin:{name} -->"), format!("<!-- end:{name} -->"));
    let start = only(text, &begin)? + begin.len();
    let stop = only(text, &end)?;
    if stop < start {
        return Err(PageError::OutOfPlace { marker: end });
    }
    Ok(format!("{}\n\n{}\n\n{}", &text[..start], content.trim(), &text[stop..]))
}

/// Position of the only `marker`.
fn only(text: &str, marker: &str) -> Result<usize, PageError> {
    let mut places = text.match_indices(marker);
    let (place, _) =
        places.next().ok_or_else(|| PageError::NoMarker { marker: marker.to_owned() })?;
    if places.next().is_some() {
        Err(PageError::OutOfPlace { marker: marker.to_owned() })
    } else {
        Ok(place)
    }
}

/// A picture in Markdown.
pub(super) fn picture(path: &str, words: &str) -> String {
    format!("![{words}]({path})")
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = "# Name\n<!-- begin:table1 -->\nold\n<!-- end:table1 -->\nmore\n";

    #[test]
    fn content_is_replaced_once_and_for_all() {
        let once = splice(PAGE, "table1", "| a |\n").unwrap();
        assert_eq!(once, "# Name\n<!-- begin:table1 -->\n\n| a |\n\n<!-- end:table1 -->\nmore\n");
        assert_eq!(splice(&once, "table1", "| a |\n").unwrap(), once);
    }

    #[test]
    fn markers_must_be_there_once_and_in_order() {
        assert!(matches!(splice(PAGE, "fig6", ""), Err(PageError::NoMarker { .. })));
        let twice = format!("{PAGE}{PAGE}");
        assert!(matches!(splice(&twice, "table1", ""), Err(PageError::OutOfPlace { .. })));
        let turned = "<!-- end:x --> <!-- begin:x -->";
        assert!(matches!(splice(turned, "x", ""), Err(PageError::OutOfPlace { .. })));
    }
}
