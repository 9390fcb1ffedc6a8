//! `report.html`: one self-contained page for somebody who has not read the code.

use super::{DRAWINGS, DiscoveryReport, answer, appendix, evidence};
use crate::report::ReportError;
use crate::report::html::{document, figure};
use maud::html;

/// The page.
///
/// # Errors
/// [`ReportError::Draw`] when a figure cannot be painted.
pub(super) fn page(report: &DiscoveryReport) -> Result<String, ReportError> {
    let [map, gap, residuals] =
        DRAWINGS.map(|(name, draw)| figure(name, |width| draw(report, width)));
    let content = html! {
        (answer::head(report))
        (answer::effects(report))
        (evidence::robot(report))
        (evidence::place(report, &map?))
        (evidence::proof(report, &gap?, &residuals?))
        (appendix::candidates(report))
        (appendix::next(report))
        (appendix::limitations(report))
        (appendix::model(report))
    };
    Ok(document(&answer::title(report), &content))
}
