//! The claims: one line a claim, both kinds of training in it.

use maud::{Markup, html};
use std::path::Path;

use super::provenance::{ClaimCost, duration};
use crate::data::DataError;
use crate::report::discovery::html::section as page_section;
use crate::report::paper::claim_lines::{ClaimCells, ClaimLine, claim_lines};
use crate::report::published_rows;
use crate::report::style::{ANY_TRAINING, training_label};
use crate::rows::experiment::ClaimRow;

/// The section and the counts for the head of the page.
pub(super) struct ClaimsSection {
    /// The section.
    pub(super) section: Markup,
    /// The counts.
    pub(super) summary: Markup,
}

/// A group of claims with the reason of its verdicts.
struct Group {
    experiment: &'static str,
    /// How the names of its claims begin.
    beginning: &'static str,
    heading: &'static str,
    why: &'static str,
}

const GROUPS: [Group; 6] = [
    Group {
        experiment: "fig5",
        beginning: "",
        heading: "Fig. 5: where the simulation errs",
        why: "Gravity acts along −x. The effects that the simulation lacks move the tip mainly in \
              that direction.",
    },
    Group {
        experiment: "table1",
        beginning: "validation_",
        heading: "Validation errors of the networks",
        why: "Training that stops at the paper’s error agrees with it by construction. Converged \
              networks have a much smaller validation error.",
    },
    Group {
        experiment: "fig6",
        beginning: "",
        heading: "Fig. 6: amount of data",
        why: "The network of π_real learns from real points only, so more points reduce its error. \
              The Gaussian process learns a smooth gap, for which a hundred points suffice.",
    },
    Group {
        experiment: "fig8",
        beginning: "",
        heading: "Fig. 8: path tracking",
        why: "C switches between A and B where the error exceeds its threshold. With stopped \
              networks it switches often: it oscillates and needs more time. With converged \
              networks the error stays below the threshold and C acts as A.",
    },
    Group {
        experiment: "table1",
        beginning: "table1_",
        heading: "Table I: the numbers",
        why: "The network makes most of the error. Networks stopped at the paper’s validation \
              errors come near its numbers in open loop; converged networks have several times \
              smaller errors, so they reproduce none of the numbers.",
    },
    Group {
        experiment: "table1",
        beginning: "",
        heading: "Table I: comparisons of controllers",
        why: "With stopped networks the controllers differ as the paper states. With converged \
              networks all reach nearly the same error, and differences are a fraction of a \
              millimetre.",
    },
];

/// The order in which the groups are shown: comparisons before numbers.
const ORDER: [usize; 6] = [5, 2, 3, 0, 4, 1];

/// Kinds of training with a column each; a claim without networks spans both.
const TRAININGS: [&str; 2] = ["paper", "converged"];

const VERDICTS: [&str; 3] = ["reproduced", "not reproduced", "undecided"];

/// The section about `claims.csv`; nothing where it is not there.
///
/// # Errors
/// [`DataError`] for a table that cannot be read.
pub(super) fn section(results: &Path, costs: &[ClaimCost]) -> Result<ClaimsSection, DataError> {
    let rows: Vec<ClaimRow> = published_rows(results)?;
    let mut lines = claim_lines(&rows);
    let mut groups = Vec::new();
    for group in &GROUPS {
        let is_here = |line: &ClaimLine| {
            let row = line.first();
            row.experiment == group.experiment && row.claim.starts_with(group.beginning)
        };
        let (here, rest): (Vec<_>, Vec<_>) = lines.into_iter().partition(is_here);
        lines = rest;
        groups.push((group.heading, group.why, here));
    }
    let mut groups: Vec<_> = ORDER.iter().map(|&index| groups[index].clone()).collect();
    groups.push(("Further claims", "", lines));
    let content = html! {
        p {
            "A claim is about one number per repetition, its " em { "quantity" } ". It is " strong { "reproduced" }
            " if the 95 % interval over the repetitions lies inside the range of “holds if”, "
            strong { "not reproduced" } " if it lies outside, and " strong { "undecided" }
            " if it crosses a limit. The time in brackets is processor time. Networks were trained \
             twice: stopped at the validation errors that the paper reports, and trained until \
             they stop improving."
        }
        div .filter role="group" aria-label="Show claims" {
            @for verdict in ["all"].into_iter().chain(VERDICTS) {
                button type="button" data-verdict=(verdict) aria-pressed=(verdict == "all") { (verdict) }
            }
        }
        @for (heading, why, lines) in &groups { (group(heading, why, lines, costs)) }
    };
    Ok(ClaimsSection {
        section: page_section("Claims of the paper", &content),
        summary: summary(&rows),
    })
}

fn summary(rows: &[ClaimRow]) -> Markup {
    let tile = |verdict: &str| {
        let of = |training: &str| {
            let is_counted = |row: &&ClaimRow| {
                row.verdict == verdict && (row.training == training || row.training == ANY_TRAINING)
            };
            rows.iter().filter(is_counted).count()
        };
        html! {
            div {
                dt { (verdict) }
                dd { (rows.iter().filter(|row| row.verdict == verdict).count()) }
                dd .note { (of("paper")) " with networks stopped at the paper’s errors, " (of("converged")) " converged" }
            }
        }
    };
    html! { dl .tiles { @for verdict in VERDICTS { (tile(verdict)) } } }
}

fn group(heading: &str, why: &str, lines: &[ClaimLine], costs: &[ClaimCost]) -> Markup {
    html! {
        @if !lines.is_empty() {
            h3 { (heading) }
            p { (why) }
            table .stack .claims {
                thead { tr {
                    th scope="col" { "Claim" } th scope="col" { "Holds if" } th scope="col" { "Paper" }
                    @for training in TRAININGS { th scope="col" { "Ours, " (training_label(training)) } }
                } }
                tbody { @for line in lines { (claim(line, costs)) } }
            }
        }
    }
}

fn claim(line: &ClaimLine, costs: &[ClaimCost]) -> Markup {
    let first = line.first();
    let verdicts: Vec<&str> = line.rows.iter().map(|row| row.verdict.as_str()).collect();
    let cells = ClaimCells::of(first);
    let cost =
        costs.iter().find(|cost| cost.experiment == first.experiment && cost.claim == first.claim);
    html! {
        tr data-verdicts=(verdicts.join(",")) {
            th scope="row" {
                q { (first.statement) }
                div .note { (first.quantity) }
                div .note {
                    code { "spinebench verify --claim " (first.claim) }
                    @if let Some(cost) = cost { " (" (duration(cost.cpu_s)) ")" }
                }
            }
            td data-label="Holds if" { (line.holds_if()) }
            td data-label="Paper" {
                @if first.paper.is_finite() { (number(first.paper, &cells.paper)) " " (cells.unit) } @else { "–" }
            }
            @if first.training == ANY_TRAINING {
                td colspan="2" data-label="Ours" { (ours(first)) }
            } @else {
                @for training in TRAININGS {
                    td data-label=(training_label(training)) {
                        @for row in line.rows.iter().filter(|row| row.training == training) { (ours(row)) }
                    }
                }
            }
        }
    }
}

/// The verdict, our number and its interval.
fn ours(row: &ClaimRow) -> Markup {
    let cells = ClaimCells::of(row);
    let class = row.verdict.replace(' ', "-");
    html! {
        span .verdict .(class) { (row.verdict) }
        div { (number(row.ours, &cells.ours)) " " (cells.unit) }
        @if let Some(interval) = &cells.interval { div .note { (interval) } }
    }
}

/// A number with the value of the table behind it.
fn number(value: f64, text: &str) -> Markup {
    html! { data value=(value) { (text) } }
}
