//! `report.html`: one self-contained page for somebody who has not read the code. No script, no link, nothing fetched.

use super::super::style::PAGE_WIDTH;
use super::html::drawing;
use super::{DRAWINGS, DiscoveryReport, answer, appendix, evidence};
use crate::report::ReportError;
use crate::report::drawing::paint;
use maud::{DOCTYPE, Markup, PreEscaped, html};

pub(in crate::report) const CSS: &str = include_str!("page.css");
/// Width of the figures on a telephone, hundredths of an inch.
const NARROW: f64 = 372.0;

/// The page.
///
/// # Errors
/// [`ReportError::Draw`] when a figure cannot be painted.
pub(super) fn page(report: &DiscoveryReport) -> Result<String, ReportError> {
    let [map, gap, residuals] = [figure(report, "map")?, figure(report, "gap")?, figure(report, "residuals")?];
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (answer::title(report)) }
                style { (PreEscaped(CSS)) }
            }
            body {
                main {
                    (answer::head(report))
                    (answer::effects(report))
                    (evidence::place(report, &map))
                    (evidence::proof(report, &gap, &residuals))
                    (appendix::candidates(report))
                    (appendix::next(report))
                    (appendix::limitations(report))
                    (appendix::model(report))
                }
            }
        }
    };
    Ok(page.into_string().replace(is_control, "\u{fffd}") + "\n")
}

/// Control characters have no place in a page.
fn is_control(letter: char) -> bool {
    letter.is_control() && letter != '\n' && letter != '\t'
}

/// A figure at the widths of a page and of a telephone, of which the page shows the one that fits.
fn figure(report: &DiscoveryReport, name: &'static str) -> Result<Markup, ReportError> {
    let failed = |error: paint::PaintError| ReportError::Draw { figure: name, reason: error.to_string() };
    let mut both = Markup::default();
    for (_, draw) in DRAWINGS.iter().filter(|(known, _)| *known == name) {
        for (class, width) in [("wide", PAGE_WIDTH), ("narrow", NARROW)] {
            if let Some(canvas) = draw(report, width) {
                both.0 += &drawing(&paint::svg(&canvas).map_err(failed)?, class, name).0;
            }
        }
    }
    Ok(both)
}
