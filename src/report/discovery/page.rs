//! `report.html`: one self-contained page for somebody who has not read the code. No script, no link, nothing fetched.

use super::super::style::PAGE_WIDTH;
use super::html::{Html, lines, tag, text, words};
use super::{DRAWINGS, DiscoveryReport, answer, appendix, evidence};
use crate::report::ReportError;
use crate::report::drawing::paint;

const CSS: &str = include_str!("page.css");
/// Width of the figures on a telephone, hundredths of an inch.
const NARROW: f64 = 372.0;

/// The page.
///
/// # Errors
/// [`ReportError::Draw`] when a figure cannot be painted.
pub(super) fn page(report: &DiscoveryReport) -> Result<String, ReportError> {
    let parts = [
        answer::head(report),
        answer::effects(report),
        evidence::place(report, figure(report, "map")?),
        evidence::proof(report, figure(report, "gap")?, figure(report, "residuals")?),
        appendix::candidates(report),
        appendix::next(report),
        appendix::limitations(report),
        appendix::model(report),
    ];
    let title = answer::title(report);
    let body = tag("main", lines(parts));
    Ok(format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n{}\n<style>\n{CSS}</style>\n</head>\n\
         <body>\n{}\n</body>\n</html>\n",
        words("title", title).as_str(),
        body.as_str()
    ))
}

/// A section; nothing where it has no content.
pub(super) fn section(heading: &str, content: Html) -> Html {
    if content.is_empty() { content } else { tag("section", words("h2", heading).and(content)) }
}

/// A figure at the widths of a page and of a telephone, of which the page shows the one that fits.
fn figure(report: &DiscoveryReport, name: &'static str) -> Result<Html, ReportError> {
    let failed = |error: paint::PaintError| ReportError::Draw { figure: name, reason: error.to_string() };
    let Some((_, draw)) = DRAWINGS.iter().find(|(known, _)| *known == name) else { return Ok(Html::default()) };
    let mut both = Html::default();
    for (class, width) in [("wide", PAGE_WIDTH), ("narrow", NARROW)] {
        if let Some(canvas) = draw(report, width) {
            both = both.and(Html::drawing(&paint::svg(&canvas).map_err(failed)?, class, name));
        }
    }
    Ok(both)
}

/// A figure with its caption; nothing for no figure.
pub(super) fn captioned(figure: Html, caption: &str) -> Html {
    if figure.is_empty() { figure } else { tag("figure", figure.and(tag("figcaption", text(caption)))) }
}
