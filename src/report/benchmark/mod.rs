//! The blind benchmark of discovery: which effects are named for which, how often the answer is
//! right.

mod cases;
mod confusion;
mod fault_isolation;
mod measures;
mod rates;
mod share;
mod table;

use super::{Artifact, Figure, Published, ReportError, captioned, csv, text};

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "discovery",
    about: "Blind benchmark of discovery: confusion matrix and rates",
    render,
};

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    let cases = &published.cases;
    FIGURE.needs("discovery.csv", cases.is_empty())?;
    let summary = measures::summary(cases);
    let mut files = vec![
        csv("summary.csv", &summary)?,
        csv("confusion.csv", &confusion::counts(cases))?,
        text("discovery.md", table::markdown(&summary)),
    ];
    let drawn = captioned(FIGURE.name, FIGURE.name, &confusion::caption(cases), |width| {
        confusion::draw(cases, width)
    });
    files.extend(drawn?);
    let drawn = captioned(FIGURE.name, "discovery_rates", &rates::caption(&summary), |width| {
        rates::draw(&summary, width)
    });
    files.extend(drawn?);
    // Older tables have no methods of comparison.
    let scores = fault_isolation::scores(cases);
    if !scores.is_empty() {
        files.push(csv("fault_isolation.csv", &scores)?);
        files.push(text("fault_isolation.md", fault_isolation::markdown(&scores)));
        let caption = fault_isolation::CAPTION;
        let drawn = captioned(FIGURE.name, "discovery_isolation", caption, |width| {
            fault_isolation::draw(&scores, width)
        });
        files.extend(drawn?);
    }
    Ok(files)
}
