//! `results/report.html`: all published results on one self-contained page. Charts are drawn in the
//! browser from the tables that the page carries, which are columns of the published CSV files.

mod charts;
mod claims;
mod provenance;
mod reasons;
mod repair;
mod sections;
mod table1;
mod tables;
mod terms;

use maud::{Markup, PreEscaped, html};
use std::path::Path;

use super::ReportError;
use super::html::document;
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
    /// The robot on the path of Fig. 8.
    pub path: PathScenes,
    /// Repetitions below which no claim is decided.
    pub repetitions_needed: u64,
    /// Error above which C switches on the path of Fig. 8, metres.
    pub switch_threshold_m: Option<f64>,
}

/// The robot on a path, a scene a policy.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathScenes {
    /// Training of the networks.
    pub training: String,
    /// Repetition, from 0.
    pub seed: u64,
    /// The scenes.
    pub scenes: Vec<Scene>,
}

/// A part of the page that its contents list.
struct PagePart {
    id: &'static str,
    heading: &'static str,
    content: Markup,
}

impl PagePart {
    fn new(id: &'static str, heading: &'static str, content: Markup) -> PagePart {
        PagePart { id, heading, content }
    }
}

/// The page for the tables below `results`. Parts whose tables are not there are left out.
///
/// # Errors
/// [`ReportError::Data`] for a table that cannot be read.
pub fn overview(results: &Path, facts: &OverviewFacts) -> Result<String, ReportError> {
    let mut data = PageData::default();
    let claims = claims::section(results, facts)?;
    let table1 = table1::section(results, &mut data)?;
    let mut parts = vec![
        PagePart::new("claims", "Claims of the paper", claims.section),
        PagePart::new("table1", "Table I", table1),
    ];
    parts.extend(sections::figures(results, facts, &mut data)?);
    parts.extend(sections::further(results, &mut data)?);
    let provenance = provenance::section(&facts.experiments, results);
    parts.push(PagePart::new("provenance", "Provenance of the numbers", provenance));
    parts.retain(|part| !part.content.0.is_empty());
    let content = html! {
        (head(&claims.summary, facts))
        (contents(&parts))
        (terms::section())
        @for part in &parts { section id=(part.id) { h2 { (part.heading) } (part.content) } }
        (scripts(&data))
    };
    Ok(document("spinebench: results", &content))
}

/// Links to the parts.
fn contents(parts: &[PagePart]) -> Markup {
    html! {
        nav .contents aria-label="Contents" {
            ul {
                li { a href="#terms" { "Terms" } }
                @for part in parts { li { a href={ "#" (part.id) } { (part.heading) } } }
            }
        }
    }
}

fn head(summary: &Markup, facts: &OverviewFacts) -> Markup {
    // Experiments that state claims of the paper.
    let of_paper = facts
        .experiments
        .iter()
        .filter(|experiment| facts.costs.iter().any(|cost| cost.experiment == experiment.name));
    let repetitions = of_paper.map(|experiment| experiment.seeds).min();
    html! {
        header {
            p .badge { "Results" }
            h1 { "Does this learning-based controller work?" }
            p .lead {
                "We repeated the experiments of Wang & Rojas, " i { "A Data-Efficient Model-Based \
                 Learning Framework for the Closed-Loop Control of Continuum Robots" } ", "
                @if let Some(repetitions) = repetitions { (repetitions) " times, " }
                "data and training included. Further experiments have the number of repetitions stated under "
                a href="#provenance" { "Provenance" } "."
            }
            p {
                strong { "The “real” robot on this page is a simulated one" } ": the rod model with \
                an injected gap and tracking noise. Only the part " a href="#real" { "Real robots" }
                " uses recordings of real robots."
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
