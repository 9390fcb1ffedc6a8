//! Where the results come from.

use maud::{Markup, html};
use std::path::Path;

/// A published experiment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExperimentFacts {
    /// Its name.
    pub name: String,
    /// Version of the program.
    pub version: String,
    /// Revision of the sources.
    pub revision: String,
    /// Repetitions.
    pub seeds: u64,
    /// Processor.
    pub processor: String,
    /// Processor time of its stages, seconds.
    pub cpu_s: f64,
}

/// What it costs to judge a claim again.
#[derive(Clone, Debug, PartialEq)]
pub struct ClaimCost {
    /// The experiment.
    pub experiment: String,
    /// The claim.
    pub claim: String,
    /// Processor time of the stages behind it, seconds.
    pub cpu_s: f64,
}

/// A duration in the unit that suits it.
pub fn duration(seconds: f64) -> String {
    match seconds {
        seconds if seconds < 90.0 => format!("{seconds:.0} s"),
        seconds if seconds < 5400.0 => format!("{:.0} min", seconds / 60.0),
        seconds => format!("{:.1} h", seconds / 3600.0),
    }
}

/// The section: one line an experiment.
pub(super) fn section(experiments: &[ExperimentFacts], results: &Path) -> Markup {
    if experiments.is_empty() {
        return Markup::default();
    }
    let line = |facts: &ExperimentFacts| {
        let revision: String = facts.revision.chars().take(10).collect();
        html! {
            tr {
                th scope="row" { code { (facts.name) } }
                td data-label="Repetitions" { (facts.seeds) }
                td data-label="Processor time" { (duration(facts.cpu_s)) }
                td data-label="Program" {
                    (facts.version) ", "
                    @if revision.is_empty() { "revision not recorded" } @else { code { (revision) } }
                }
                td data-label="Processor" { (facts.processor) }
            }
        }
    };
    html! {
        p {
            "Each experiment is a YAML file. " code { "results/NAME/spec.yaml" } " states every setting of \
             a run, " code { "stages.csv" } " every stage with its key and result. " code { "spinebench verify NAME" }
            " reruns an experiment without stored results and compares every byte. A revision \
             that ends in "
            code { "+" } " had uncommitted changes."
        }
        @if results.join("real").is_dir() {
            p {
                "Real robots (" code { "results/real" } ") are no experiment of this kind: " code { "make real" }
                " calibrates models with recordings that other groups published, which are not part of this \
                 repository. It has no repetitions, and its revision is not recorded."
            }
        }
        table .stack {
            thead { tr { th scope="col" { "Experiment" } th scope="col" { "Repetitions" } th scope="col" { "Processor time" }
                th scope="col" { "Program" } th scope="col" { "Processor" } } }
            tbody { @for facts in experiments { (line(facts)) } }
        }
    }
}
