//! HTML that cannot be broken by what it says: text is escaped where it enters, markup comes from the source alone.

/// A table of more columns scrolls on a telephone.
const MANY: usize = 4;

/// A piece of a page, well formed.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Html(String);

impl Html {
    /// The piece as it stands in the file.
    pub(super) fn as_str(&self) -> &str {
        &self.0
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// This and then `next`.
    pub(super) fn and(mut self, next: Html) -> Html {
        self.0.push_str(&next.0);
        self
    }

    /// A drawing of our own painter, which escapes its texts, with a name for those who do not see it.
    pub(super) fn drawing(svg: &[u8], class: &'static str, name: &str) -> Html {
        let svg = String::from_utf8_lossy(svg);
        let start = format!("<svg class=\"{class}\" role=\"img\" aria-label=\"{}\" ", escaped(name));
        Html(svg.replacen("<svg ", &start, 1))
    }
}

/// Text, escaped.
pub(super) fn text(words: impl AsRef<str>) -> Html {
    Html(escaped(words.as_ref()))
}

/// An element around `inner`; `open` is its name with any attributes.
pub(super) fn tag(open: &'static str, inner: Html) -> Html {
    let name = open.split(' ').next().unwrap_or(open);
    Html(format!("<{open}>{}</{name}>", inner.0))
}

/// An element around text.
pub(super) fn words(open: &'static str, inner: impl AsRef<str>) -> Html {
    tag(open, text(inner))
}

/// Pieces one after the other, each on a line of its own.
pub(super) fn lines(pieces: impl IntoIterator<Item = Html>) -> Html {
    let pieces: Vec<String> = pieces.into_iter().filter(|piece| !piece.is_empty()).map(|piece| piece.0).collect();
    Html(pieces.join("\n"))
}

/// A table that scrolls by itself where the page is narrow; nothing for no rows. The first cell of a row heads it.
pub(super) fn table(header: &[&str], rows: Vec<Vec<Html>>) -> Html {
    if rows.is_empty() {
        return Html::default();
    }
    let head = lines(header.iter().map(|name| words("th scope=\"col\"", name)));
    let line = |cells: Vec<Html>| {
        let open = |index| if index == 0 { "th scope=\"row\"" } else { "td" };
        tag("tr", lines(cells.into_iter().enumerate().map(|(index, cell)| tag(open(index), cell))))
    };
    let body = lines(rows.into_iter().map(line));
    let whole = tag("table", tag("thead", tag("tr", head)).and(tag("tbody", body)));
    let many = header.len() > MANY;
    tag(if many { "div class=\"scroll many\"" } else { "div class=\"scroll\"" }, whole)
}

/// A list; nothing for no items.
pub(super) fn list(items: impl IntoIterator<Item = Html>) -> Html {
    let items = lines(items.into_iter().map(|item| tag("li", item)));
    if items.is_empty() { items } else { tag("ul", items) }
}

/// What may stand between tags and within quotes; control characters have no place in a page.
fn escaped(words: &str) -> String {
    let mut out = String::with_capacity(words.len());
    for letter in words.chars() {
        match letter {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\n' | '\t' => out.push(letter),
            other if other.is_control() => out.push('\u{fffd}'),
            other => out.push(other),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_wherever_it_enters() {
        let nasty = "<script>alert(\"1\" & '2')</script>\u{0}\u{1b}";
        let piece = tag("p", text(nasty)).and(table(&[nasty], vec![vec![text(nasty)]])).and(list([text(nasty)]));
        let page = piece.as_str();
        assert!(!page.contains("<script") && !page.contains('\u{0}') && !page.contains('\u{1b}'), "{page}");
        assert_eq!(page.matches("&lt;script&gt;alert(&quot;1&quot; &amp; &#39;2&#39;)").count(), 4);
        let drawing = Html::drawing(b"<svg width=\"1\"></svg>", "wide", nasty);
        assert!(drawing.as_str().contains("aria-label=\"&lt;script&gt;"), "{}", drawing.as_str());
    }

    #[test]
    fn elements_close_with_their_name_alone() {
        assert_eq!(words("p class=\"note\"", "a").as_str(), "<p class=\"note\">a</p>");
        assert!(table(&["a"], Vec::new()).is_empty() && list([]).is_empty());
    }
}
