//! Pieces of the page that several sections use: sections, figures, tables, lists.

use maud::{Markup, PreEscaped, Render, html};

/// A table with more columns scrolls on a telephone.
const MANY: usize = 4;

/// A drawing of our own painter, which escapes its texts, with a name for readers who do not see it.
pub(in crate::report) fn drawing(svg: &[u8], class: &'static str, name: &str) -> Markup {
    let svg = String::from_utf8_lossy(svg);
    let label = name.render().into_string();
    let start = format!("<svg class=\"{class}\" role=\"img\" aria-label=\"{label}\" ");
    PreEscaped(svg.replacen("<svg ", &start, 1))
}

/// A section; nothing where it has no content.
pub(in crate::report) fn section(heading: &str, content: &Markup) -> Markup {
    html! { @if !content.0.is_empty() { section { h2 { (heading) } (content) } } }
}

/// A figure with its caption; nothing for no figure.
pub(in crate::report) fn captioned(figure: &Markup, caption: &str) -> Markup {
    html! { @if !figure.0.is_empty() { figure { (figure) figcaption { (caption) } } } }
}

/// A table that scrolls by itself on a narrow page; nothing for no rows. The first cell of a row is its header.
pub(in crate::report) fn table(header: &[&str], rows: &[Vec<Markup>]) -> Markup {
    html! {
        @if !rows.is_empty() {
            div .scroll .many[header.len() > MANY] {
                table {
                    thead { tr { @for name in header { th scope="col" { (name) } } } }
                    tbody {
                        @for row in rows {
                            tr {
                                @for (index, cell) in row.iter().enumerate() {
                                    @if index == 0 { th scope="row" { (cell) } } @else { td { (cell) } }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// A list; nothing for no items.
pub(in crate::report) fn list<T: Render>(items: &[T]) -> Markup {
    html! { @if !items.is_empty() { ul { @for item in items { li { (item) } } } } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_wherever_it_enters() {
        let nasty = "<script>alert(\"1\" & '2')</script>";
        let piece = html! { p { (nasty) } (table(&[nasty], &[vec![html! { (nasty) }]])) (list(&[nasty])) };
        let page = piece.into_string();
        assert!(!page.contains("<script"), "{page}");
        assert_eq!(page.matches("&lt;script&gt;alert(&quot;1&quot; &amp; '2')").count(), 4);
        let drawing = drawing(b"<svg width=\"1\"></svg>", "wide", nasty).into_string();
        assert!(drawing.contains("aria-label=\"&lt;script&gt;"), "{drawing}");
    }

    #[test]
    fn no_rows_and_no_items_are_nothing() {
        assert!(table(&["a"], &[]).into_string().is_empty() && list::<&str>(&[]).into_string().is_empty());
    }
}
