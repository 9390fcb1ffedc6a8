//! The end of the page: what else was considered, what to record next, limitations, and what was
//! added to the model.

use super::DiscoveryReport;
use super::format::{millimetres, number, times};
use super::html::{list, section, table};
use super::model_diff::{DiffLine, compare};
use maud::{Markup, html};

/// Candidates in the table; the others are in `candidates.csv`.
const MAX_CANDIDATES: usize = 30;
/// Lines that are shown around those that changed.
const CONTEXT_LINES: usize = 2;

/// What else was considered, and why not.
pub(crate) fn candidates(report: &DiscoveryReport) -> Markup {
    let (candidates, floor_m) = (&report.findings.candidates, report.findings.noise_floor_m);
    let rows = candidates.iter().take(MAX_CANDIDATES).map(|candidate| {
        let why = html! { @if candidate.why_not.is_empty() { strong { "the answer" } } @else { (candidate.why_not) } };
        // Without one of the trials the others do not pin it down.
        let unstable = candidate.after_m > report.findings.gap.before_m;
        let [error, over] = match unstable {
            true => ["depends on single trials".to_owned(), String::new()],
            false => [millimetres(candidate.after_m), times(candidate.after_m, floor_m)],
        };
        let numbers = [score(candidate.score), error, over].map(|number| html! { (number) });
        std::iter::once(html! { code { (candidate.name) } }).chain(numbers).chain([why]).collect()
    });
    let rows: Vec<Vec<Markup>> = rows.collect();
    if rows.is_empty() {
        return Markup::default();
    }
    let more = candidates.len().saturating_sub(MAX_CANDIDATES);
    let beyond =
        if more > 0 { format!(" {more} more are in candidates.csv.") } else { String::new() };
    let before = report.before();
    let note = format!(
        "Score: gain in 2 ln likelihood over the {before}, minus a penalty for parameters and for \
         the number of candidates; larger is better. Error: leave-one-trial-out error after \
         removal of uncertain parameters and of errors shared with the baseline; the error of the \
         model alone, as in the held-out test, can be larger."
    );
    let header = ["candidate", "score", "error", "over the floor", "why not"];
    section("Other candidates", &html! { (table(&header, &rows)) p .note { (note) (beyond) } })
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
    let header = ["recording", "what to do", "minutes", "separation (σ)", "commands"];
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
            &html! { p { "Nothing was added: model.yaml equals the given model." } },
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
