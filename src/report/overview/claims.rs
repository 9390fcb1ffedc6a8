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

/// Groups of claims: experiment and beginning of the claim's name, heading.
const GROUPS: [(&str, &str, &str); 6] = [
    ("fig5", "", "Fig. 5: where the simulation is wrong"),
    ("table1", "table1_", "Table I: the numbers"),
    ("table1", "validation_", "Validation errors of the networks"),
    ("table1", "", "Table I: comparisons of controllers"),
    ("fig6", "", "Fig. 6: amount of data"),
    ("fig8", "", "Fig. 8: path tracking"),
];

const VERDICTS: [&str; 3] = ["reproduced", "not reproduced", "undecided"];

/// The section about `claims.csv`; nothing where it is not there.
///
/// # Errors
/// [`DataError`] for a table that cannot be read.
pub(super) fn section(results: &Path, costs: &[ClaimCost]) -> Result<ClaimsSection, DataError> {
    let rows: Vec<ClaimRow> = published_rows(results)?;
    let mut lines = claim_lines(&rows);
    let mut groups = Vec::new();
    for (experiment, beginning, heading) in GROUPS {
        let is_here = |line: &ClaimLine| {
            let row = line.first();
            row.experiment == experiment && row.claim.starts_with(beginning)
        };
        let (here, rest): (Vec<_>, Vec<_>) = lines.into_iter().partition(is_here);
        lines = rest;
        groups.push((heading, here));
    }
    groups.push(("Further claims", lines));
    let content = html! {
        p {
            "A claim is one number a repetition, its " em { "quantity" } ". It is " strong { "reproduced" }
            " where the 95 % interval over the repetitions lies inside the range of “holds if”, "
            strong { "not reproduced" } " where it lies outside, and " strong { "undecided" }
            " where it crosses a limit. Networks were trained twice: stopped at the validation errors that \
             the paper reports, and trained until they stop to improve."
        }
        div .filter role="group" aria-label="Show claims" {
            @for verdict in ["all"].into_iter().chain(VERDICTS) {
                button type="button" data-verdict=(verdict) aria-pressed=(verdict == "all") { (verdict) }
            }
        }
        @for (heading, lines) in &groups { (group(heading, lines, costs)) }
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

fn group(heading: &str, lines: &[ClaimLine], costs: &[ClaimCost]) -> Markup {
    html! {
        @if !lines.is_empty() {
            h3 { (heading) }
            table .stack .claims {
                thead { tr { th scope="col" { "Claim" } th scope="col" { "Holds if" } th scope="col" { "Paper" }
                    th scope="col" { "Ours, 95 % interval" } th scope="col" { "Again" } } }
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
            th scope="row" { q { (first.statement) } div .note { (first.quantity) } }
            td data-label="Holds if" { (line.holds_if()) }
            td data-label="Paper" {
                @if first.paper.is_finite() { (number(first.paper, &cells.paper)) " " (cells.unit) } @else { "–" }
            }
            td data-label="Ours" { @for row in &line.rows { (ours(row)) } }
            td data-label="Again" {
                code { "spinebench verify --claim " (first.claim) }
                @if let Some(cost) = cost { div .note { (duration(cost.cpu_s)) " of processor time" } }
            }
        }
    }
}

/// Our number, its interval and the verdict.
fn ours(row: &ClaimRow) -> Markup {
    let cells = ClaimCells::of(row);
    let class = row.verdict.replace(' ', "-");
    html! {
        div .ours {
            span .verdict .(class) { (row.verdict) }
            " " (number(row.ours, &cells.ours)) " " (cells.unit)
            @if let Some(interval) = &cells.interval { " " span .note { (interval) } }
            @if row.training != ANY_TRAINING { div .note { (training_label(&row.training)) } }
        }
    }
}

/// A number with the value of the table behind it.
fn number(value: f64, text: &str) -> Markup {
    html! { data value=(value) { (text) } }
}
