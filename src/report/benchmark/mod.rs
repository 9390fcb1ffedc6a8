//! The blind benchmark of discovery: which effects are named for which, how often the answer is
//! right, and what is left of it with fewer samples.

mod cases;
mod confusion;
mod fault_isolation;
mod measures;
mod rates;
mod samples;
mod share;
mod table;

use super::{Artifact, Figure, Published, ReportError, csv, pictures, text};

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "discovery",
    about: "Blind benchmark of discovery: confusion matrix, rates, samples",
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
    files.extend(pictures(FIGURE.name, FIGURE.name, &confusion::draw(cases))?);
    files.extend(pictures(FIGURE.name, "discovery_rates", &rates::draw(&summary))?);
    files.extend(pictures(FIGURE.name, "discovery_samples", &samples::draw(cases))?);
    // Older tables have no methods of comparison.
    let scores = fault_isolation::scores(cases);
    if !scores.is_empty() {
        files.push(csv("fault_isolation.csv", &scores)?);
        files.push(text("fault_isolation.md", fault_isolation::markdown(&scores)));
        let drawn = fault_isolation::draw(&scores);
        files.extend(pictures(FIGURE.name, "discovery_isolation", &drawn)?);
    }
    Ok(files)
}
