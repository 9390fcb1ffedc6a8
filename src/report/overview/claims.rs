//! The claims: one line a claim, both kinds of training in it.

use maud::{Markup, html};
use std::path::Path;

use super::OverviewFacts;
use super::provenance::{ClaimCost, duration};
use super::reasons::{Reasons, verdicts_by_training};
use crate::data::DataError;
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

/// A group of claims.
struct Group {
    experiment: &'static str,
    /// How the names of its claims begin.
    beginning: &'static str,
    heading: &'static str,
}

const GROUPS: [Group; 6] = [
    Group { experiment: "fig5", beginning: "", heading: "Fig. 5: where the simulation errs" },
    Group {
        experiment: "table1",
        beginning: "validation_",
        heading: "Validation errors of the networks",
    },
    Group { experiment: "fig6", beginning: "", heading: "Fig. 6: amount of data" },
    Group { experiment: "fig8", beginning: "", heading: "Fig. 8: path tracking" },
    Group { experiment: "table1", beginning: "table1_", heading: "Table I: the numbers" },
    Group { experiment: "table1", beginning: "", heading: "Table I: comparisons of controllers" },
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
pub(super) fn section(results: &Path, facts: &OverviewFacts) -> Result<ClaimsSection, DataError> {
    let rows: Vec<ClaimRow> = published_rows(results)?;
    let reasons = Reasons::read(results, facts)?;
    let mut lines = claim_lines(&rows);
    let mut groups = Vec::new();
    for (index, group) in GROUPS.iter().enumerate() {
        let is_here = |line: &ClaimLine| {
            let row = line.first();
            row.experiment == group.experiment && row.claim.starts_with(group.beginning)
        };
        let (here, rest): (Vec<_>, Vec<_>) = lines.into_iter().partition(is_here);
        lines = rest;
        groups.push((group.heading, reasons.of_group(index), here));
    }
    let mut groups: Vec<_> = ORDER.iter().map(|&index| groups[index].clone()).collect();
    groups.push(("Further claims", Markup::default(), lines));
    let needed = facts.repetitions_needed;
    let content = html! {
        p {
            "A claim is about one number per repetition, its " em { "quantity" } ". It is " strong { "reproduced" }
            " if the 95 % interval over the repetitions lies inside the range of “holds if”, "
            strong { "not reproduced" } " if it lies outside, and " strong { "undecided" }
            " if it crosses a limit or if fewer than " (needed) " repetitions gave a number; then n is \
             printed. The time in brackets is processor time. Networks were trained \
             twice: stopped at the validation errors that the paper reports, and trained until \
             they stop improving."
        }
        p {
            "The paper states some claims without a number. “Holds if” then is our reading, set in the \
             experiment file: “comparable” and “similar” mean that the largest error is less than a \
             multiple of the smallest (the factor is in the quantity), “does not improve” that the gain is \
             below a tenth of the paper’s error of A in closed loop, and a completion time may differ by a \
             tenth."
        }
        div .filter role="group" aria-label="Show claims" {
            @for verdict in ["all"].into_iter().chain(VERDICTS) {
                button type="button" data-verdict=(verdict) aria-pressed=(verdict == "all") { (verdict) }
            }
        }
        @for (heading, why, lines) in &groups { (group(heading, why, lines, facts)) }
    };
    Ok(ClaimsSection { section: content, summary: summary(&rows) })
}

fn summary(rows: &[ClaimRow]) -> Markup {
    let tile = |verdict: &str| {
        let of = |training: &str| {
            let is_counted = |row: &&ClaimRow| row.verdict == verdict && row.training == training;
            rows.iter().filter(is_counted).count()
        };
        html! {
            div {
                dt { (verdict) }
                dd { (rows.iter().filter(|row| row.verdict == verdict).count()) }
                dd .note {
                    (of("paper")) " with networks stopped at the paper’s errors, " (of("converged")) " converged"
                    @if of(ANY_TRAINING) > 0 { ", " (of(ANY_TRAINING)) " independent of the training" }
                }
            }
        }
    };
    html! { dl .tiles { @for verdict in VERDICTS { (tile(verdict)) } } }
}

fn group(heading: &str, why: &Markup, lines: &[ClaimLine], facts: &OverviewFacts) -> Markup {
    html! {
        @if !lines.is_empty() {
            h3 { (heading) }
            p { (verdicts_by_training(lines)) " " (why) }
            table .stack .claims {
                thead { tr {
                    th scope="col" { "Claim" } th scope="col" { "Holds if" } th scope="col" { "Paper" }
                    @for training in TRAININGS { th scope="col" { "Ours, " (training_label(training)) } }
                } }
                tbody { @for line in lines { (claim(line, facts)) } }
            }
        }
    }
}

fn claim(line: &ClaimLine, facts: &OverviewFacts) -> Markup {
    let first = line.first();
    let verdicts: Vec<&str> = line.rows.iter().map(|row| row.verdict.as_str()).collect();
    let cells = ClaimCells::of(first);
    let is_cost =
        |cost: &&ClaimCost| cost.experiment == first.experiment && cost.claim == first.claim;
    let cost = facts.costs.iter().find(is_cost);
    let needed = facts.repetitions_needed;
    html! {
        tr data-verdicts=(verdicts.join(",")) {
            th scope="row" {
                q { (first.statement) }
                div .note dir="ltr" { (first.quantity) }
                div .note {
                    code dir="ltr" { "spinebench verify --claim " (first.claim) }
                    @if let Some(cost) = cost { " (" (duration(cost.cpu_s)) ")" }
                }
            }
            td data-label="Holds if" dir="ltr" { (line.holds_if()) }
            td data-label="Paper" dir="ltr" {
                @if first.paper.is_finite() { (number(first.paper, &cells.paper)) " " (cells.unit) } @else { "–" }
            }
            @if first.training == ANY_TRAINING {
                td colspan="2" data-label="Ours" { (ours(first, needed)) div .note { "independent of the training of networks" } }
            } @else {
                @for training in TRAININGS {
                    td data-label=(training_label(training)) {
                        @for row in line.rows.iter().filter(|row| row.training == training) { (ours(row, needed)) }
                    }
                }
            }
        }
    }
}

/// The verdict, our number and its interval, and how many repetitions gave a number where that is
/// too few.
fn ours(row: &ClaimRow, needed: u64) -> Markup {
    let cells = ClaimCells::of(row);
    let class = row.verdict.replace(' ', "-");
    html! {
        span .verdict .(class) { (row.verdict) }
        div dir="ltr" { (number(row.ours, &cells.ours)) " " (cells.unit) }
        @if let Some(interval) = &cells.interval { div .note dir="ltr" { (interval) } }
        @if row.seeds < needed { div .note .too-few { "n = " (row.seeds) " repetitions, " (needed) " needed" } }
    }
}

/// A number with the value of the table behind it.
fn number(value: f64, text: &str) -> Markup {
    html! { data value=(value) { (text) } }
}
