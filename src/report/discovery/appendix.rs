//! The end of the page: what else was considered, what to record next, limitations, and what was
//! added to the model.

use super::DiscoveryReport;
use super::format::number;
use super::model_diff::{DiffLine, compare};
use crate::data::findings::Candidate;
use crate::report::html::{list, section, table};
use maud::{Markup, html};

/// Candidates that are shown at once.
const SHOWN_CANDIDATES: usize = 5;
/// Lines that are shown around those that changed.
const CONTEXT_LINES: usize = 2;

/// What else was considered, and why not: the best candidates, the others folded.
pub(crate) fn candidates(report: &DiscoveryReport) -> Markup {
    let candidates = &report.findings.candidates;
    if candidates.is_empty() {
        return Markup::default();
    }
    let row = |candidate: &Candidate| {
        let why = html! { @if candidate.why_not.is_empty() { strong { "the answer" } } @else { (candidate.why_not) } };
        vec![html! { code { (candidate.name) } }, html! { (score(candidate.score)) }, why]
    };
    let rows: Vec<Vec<Markup>> = candidates.iter().map(row).collect();
    let (shown, folded) = rows.split_at(rows.len().min(SHOWN_CANDIDATES));
    let header = ["candidate", "score", "reason for rejection"];
    let note = format!(
        "Score: gain in 2 ln likelihood over the {}, minus a penalty for parameters and for the \
         number of candidates; larger is better. candidates.csv has all {} with their \
         leave-one-trial-out errors.",
        report.before(),
        candidates.len()
    );
    let content = html! {
        (table(&header, shown))
        @if !folded.is_empty() {
            details { summary { (folded.len()) " more candidates" } (table(&header, folded)) }
        }
        p .note { (note) }
    };
    section("Other candidates", &content)
}

/// A score; what is close to a threshold is shown with a decimal.
fn score(score: f64) -> String {
    if score.abs() < 10.0 { number(score, 2) } else { number(score, 1) }
}

/// What to record next.
pub(crate) fn next(report: &DiscoveryReport) -> Markup {
    let findings = report.findings;
    let rows = findings.proposals.iter().map(|proposal| {
        vec![
            html! { (proposal.name.replace('_', " ")) },
            html! { (proposal.what) },
            html! { (number(proposal.minutes, 2)) },
            html! { (number(proposal.separation, 2)) },
            html! { code { (proposal.file) } },
        ]
    });
    let header = ["recording", "instruction", "minutes", "separation (σ)", "commands"];
    let proposals = table(&header, &rows.collect::<Vec<_>>());
    let note = "Separation: smallest distance between the predictions of two rivals after \
                refitting, in standard deviations of the noise.";
    let content = html! {
        @if !findings.next_measurement.is_empty() { p { (findings.next_measurement) } }
        (proposals)
        @if !proposals.0.is_empty() { p .note { (note) } }
    };
    section("What to record next", &content)
}

/// What these data could not show.
pub(crate) fn limitations(report: &DiscoveryReport) -> Markup {
    section("Limitations", &list(&report.findings.limitations))
}

/// The lines of the model that are new.
pub(crate) fn model(report: &DiscoveryReport) -> Markup {
    let diff_lines = compare(report.model_before, report.model_after);
    let changed = |line: &DiffLine| !matches!(line, DiffLine::Kept(_));
    if !diff_lines.iter().any(changed) {
        return section(
            "The model",
            &html! { p { "The model was not changed: model.yaml equals the given model." } },
        );
    }
    let near_change = |at: usize| {
        let [from, to] =
            [at.saturating_sub(CONTEXT_LINES), (at + CONTEXT_LINES + 1).min(diff_lines.len())];
        diff_lines[from..to].iter().any(changed)
    };
    let mut shown = Vec::new();
    let mut left_out = false;
    for (at, line) in diff_lines.iter().enumerate() {
        if !near_change(at) {
            left_out = true;
            continue;
        }
        if std::mem::take(&mut left_out) {
            shown.push(html! { span .kept { "  …" } });
        }
        shown.push(match line {
            DiffLine::Kept(line) => html! { span .kept { "  " (line) } },
            DiffLine::Added(line) => html! { ins { "+ " (line) } },
            DiffLine::Removed(line) => html! { del { "- " (line) } },
        });
    }
    let note = "Lines added (+) to the model. The complete model is model.yaml.";
    let diff =
        html! { @for (index, line) in shown.iter().enumerate() { @if index > 0 { "\n" } (line) } };
    section("The model", &html! { p { (note) } pre { (diff) } })
}
