//! Pieces of the pages that several sections use: the document, sections, figures, tables, lists.

use maud::{DOCTYPE, Markup, PreEscaped, Render, html};

use crate::report::ReportError;
use crate::report::drawing::{Canvas, PaintError, svg};
use crate::report::style::PAGE_WIDTH;

/// Width of the figures on a telephone, hundredths of an inch.
const TELEPHONE_WIDTH: f64 = 372.0;

/// A self-contained document: no script, no link, nothing fetched.
pub(crate) fn document(title: &str, content: &Markup) -> String {
    let style = html! { style { (PreEscaped(include_str!("page.css"))) } };
    document_with_head(title, &style, content)
}

/// A document with further elements in its head. Its control characters become replacement
/// characters.
pub(crate) fn document_with_head(title: &str, head: &Markup, content: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                (head)
            }
            body { main { (content) } }
        }
    };
    let is_control = |letter: char| letter.is_control() && letter != '\n' && letter != '\t';
    page.into_string().replace(is_control, "\u{fffd}") + "\n"
}

/// A figure at the widths of a page and of a telephone, of which the page shows the one that fits;
/// nothing where there is nothing to draw.
///
/// # Errors
/// [`ReportError::Draw`] when it cannot be painted.
pub(crate) fn figure(
    name: &'static str,
    draw: impl Fn(f64) -> Option<Canvas>,
) -> Result<Markup, ReportError> {
    let failed = |error: PaintError| ReportError::Draw { figure: name, reason: error.to_string() };
    let mut drawings = Markup::default();
    for (class, width) in [("wide", PAGE_WIDTH), ("narrow", TELEPHONE_WIDTH)] {
        if let Some(canvas) = draw(width) {
            drawings.0 += &drawing(&svg(&canvas).map_err(failed)?, class, name).0;
        }
    }
    Ok(drawings)
}

/// A drawing of our own painter, which escapes its texts, with a name for readers who do not see
/// it.
fn drawing(svg: &[u8], class: &'static str, name: &str) -> Markup {
    let svg = String::from_utf8_lossy(svg);
    let label = name.render().into_string();
    let start = format!("<svg class=\"{class}\" role=\"img\" aria-label=\"{label}\" ");
    PreEscaped(svg.replacen("<svg ", &start, 1))
}

/// A section; nothing where it has no content.
pub(crate) fn section(heading: &str, content: &Markup) -> Markup {
    html! { @if !content.0.is_empty() { section { h2 { (heading) } (content) } } }
}

/// A figure with its caption; nothing for no figure.
pub(crate) fn captioned(figure: &Markup, caption: &str) -> Markup {
    html! { @if !figure.0.is_empty() { figure { (figure) figcaption { (caption) } } } }
}

/// A table whose rows stack on a telephone; nothing for no rows. The first cell of a row is its
/// header.
pub(crate) fn table(header: &[&str], rows: &[Vec<Markup>]) -> Markup {
    html! {
        @if !rows.is_empty() {
            table .stack {
                thead { tr { @for name in header { th scope="col" { (name) } } } }
                tbody {
                    @for row in rows {
                        tr {
                            @for (cell, name) in row.iter().zip(header) {
                                @if std::ptr::eq(name, &header[0]) { th scope="row" { (cell) } }
                                @else { td data-label=(name) { (cell) } }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Cells of a row.
pub(crate) fn cells(texts: impl IntoIterator<Item = impl Render>) -> Vec<Markup> {
    texts.into_iter().map(|text| html! { (text) }).collect()
}

/// A list; nothing for no items.
pub(crate) fn list<T: Render>(items: &[T]) -> Markup {
    html! { @if !items.is_empty() { ul { @for item in items { li { (item) } } } } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_wherever_it_enters() {
        let nasty = "<script>alert(\"1\" & '2')</script>";
        let piece =
            html! { p { (nasty) } (table(&[nasty], &[vec![html! { (nasty) }]])) (list(&[nasty])) };
        let page = piece.into_string();
        assert!(!page.contains("<script"), "{page}");
        assert_eq!(page.matches("&lt;script&gt;alert(&quot;1&quot; &amp; '2')").count(), 4);
        let drawing = drawing(b"<svg width=\"1\"></svg>", "wide", nasty).into_string();
        assert!(drawing.contains("aria-label=\"&lt;script&gt;"), "{drawing}");
    }

    #[test]
    fn no_rows_and_no_items_are_nothing() {
        assert!(
            table(&["a"], &[]).into_string().is_empty()
                && list::<&str>(&[]).into_string().is_empty()
        );
    }
}
