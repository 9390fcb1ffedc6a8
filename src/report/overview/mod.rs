//! `results/report.html`: all published results on one self-contained page. Charts are drawn in the
//! browser from the tables that the page carries, which are columns of the published CSV files.

mod charts;
mod claims;
mod provenance;
mod sections;
mod table1;
mod tables;

use maud::{Markup, PreEscaped, html};
use std::path::Path;

use super::ReportError;
use super::discovery::html::document;
use crate::data::scene::Scene;
use charts::PageData;

pub use provenance::{ClaimCost, ExperimentFacts, duration};

/// What the page knows beside the tables.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OverviewFacts {
    /// The published experiments, in the order of the page.
    pub experiments: Vec<ExperimentFacts>,
    /// What it costs to judge each claim again.
    pub costs: Vec<ClaimCost>,
    /// The robot on the path of Fig. 8, a scene a policy.
    pub path: Vec<Scene>,
}

/// The page for the tables below `results`. Parts whose tables are not there are left out.
///
/// # Errors
/// [`ReportError::Data`] for a table that cannot be read.
pub fn overview(results: &Path, facts: &OverviewFacts) -> Result<String, ReportError> {
    let mut data = PageData::default();
    let claims = claims::section(results, &facts.costs)?;
    let table1 = table1::section(results, &mut data)?;
    let figures = sections::figures(results, &facts.path, &mut data)?;
    let further = sections::further(results, &mut data)?;
    let content = html! {
        (head(&claims.summary))
        (claims.section)
        (table1)
        (figures)
        (further)
        (provenance::section(&facts.experiments))
        (scripts(&data))
    };
    Ok(document("spinebench: results", &content))
}

fn head(summary: &Markup) -> Markup {
    html! {
        header {
            p .badge { "Results" }
            h1 { "Does this learning-based controller work?" }
            p .lead {
                "We repeated every experiment of Wang & Rojas, " i { "A Data-Efficient Model-Based \
                 Learning Framework for the Closed-Loop Control of Continuum Robots" } ", ten times, \
                 data and training included."
            }
            p {
                strong { "The “real” robot on this page is a simulated one" } ": the rod model with \
                an injected gap and tracking noise. Only the last part uses recordings of real robots."
            }
            (summary)
        }
    }
}

/// The tables and charts as JSON, the styles of the charts and the program that draws them.
fn scripts(data: &PageData) -> Markup {
    html! {
        style { (PreEscaped(include_str!("overview.css"))) }
        script type="application/json" id="data" { (PreEscaped(data.to_json())) }
        script { (PreEscaped(include_str!("overview.js"))) }
    }
}
