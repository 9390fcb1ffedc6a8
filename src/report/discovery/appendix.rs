//! The end of the page: what else was considered, what to record next, limitations, and what was added to the model.

use super::DiscoveryReport;
use super::format::{millimetres, number, times};
use super::html::{Html, lines, list, table, tag, text, words};
use super::model_diff::{DiffLine, compare};
use super::page::section;

/// Candidates in the table; the others are in `candidates.csv`.
const CANDIDATES: usize = 30;
/// Lines that are shown around those that changed.
const CONTEXT: usize = 2;

/// What else was considered, and why not.
pub(crate) fn candidates(report: &DiscoveryReport) -> Html {
    let (candidates, floor_m) = (&report.findings.candidates, report.findings.noise_floor_m);
    let rows = candidates.iter().take(CANDIDATES).map(|one| {
        let why = if one.why_not.is_empty() { words("strong", "the answer") } else { text(&one.why_not) };
        // Without one of the trials the others do not pin it down.
        let hangs = one.after_m > report.findings.gap.before_m;
        let [error, over] = match hangs {
            true => ["hangs on single trials".to_owned(), String::new()],
            false => [millimetres(one.after_m), times(one.after_m, floor_m)],
        };
        let numbers = [score(one.score), error, over].map(text);
        std::iter::once(words("code", &one.name)).chain(numbers).chain([why]).collect::<Vec<Html>>()
    });
    let rows: Vec<Vec<Html>> = rows.collect();
    if rows.is_empty() {
        return Html::default();
    }
    let more = candidates.len().saturating_sub(CANDIDATES);
    let beyond = if more > 0 { format!(" {more} more stand in candidates.csv.") } else { String::new() };
    let before = report.before();
    let note = format!(
        "Score: how much better the data are explained than by the {before} (2 ln of the likelihood), less a penalty for \
         parameters and for the number of candidates; more is better. Errors are on trials that the candidate’s fit has \
         not seen, without what is uncertain of any robot or in common with the baseline: the model alone, as in the \
         proof, may err by more."
    );
    let header = ["candidate", "score", "error", "over the floor", "why not"];
    section("What else was considered", lines([table(&header, rows), words("p class=\"note\"", note + &beyond)]))
}

/// A score; what is close to a threshold is shown with a decimal.
fn score(score: f64) -> String {
    if score.abs() < 10.0 { number(score, 2) } else { number(score, 1) }
}

/// What to record next.
pub(crate) fn next(report: &DiscoveryReport) -> Html {
    let findings = report.findings;
    let rows = findings.proposals.iter().map(|one| {
        vec![
            text(one.name.replace('_', " ")),
            text(&one.what),
            text(number(one.minutes, 2)),
            text(number(one.separation, 2)),
            words("code", &one.file),
        ]
    });
    let header = ["recording", "what to do", "minutes", "separation (σ)", "commands"];
    let proposals = table(&header, rows.collect());
    let note = "Separation: how far apart the two rivals that are hardest to tell would be, in standard deviations of \
                the noise, after each has been fitted again.";
    let note = if proposals.is_empty() { Html::default() } else { words("p class=\"note\"", note) };
    let advice = match findings.next_measurement.as_str() {
        "" => Html::default(),
        advice => words("p", advice),
    };
    section("What to record next", lines([advice, proposals, note]))
}

/// What these data could not show.
pub(crate) fn limitations(report: &DiscoveryReport) -> Html {
    section("Limitations", list(report.findings.limitations.iter().map(text)))
}

/// The lines of the model that are new.
pub(crate) fn model(report: &DiscoveryReport) -> Html {
    let lines_ = compare(report.model_before, report.model_after);
    let changed = |line: &DiffLine| !matches!(line, DiffLine::Kept(_));
    if !lines_.iter().any(changed) {
        let words_ = "Nothing was added: model.yaml is the model as given.";
        return section("The model", words("p", words_));
    }
    let near = |at: usize| {
        let [from, to] = [at.saturating_sub(CONTEXT), (at + CONTEXT + 1).min(lines_.len())];
        lines_[from..to].iter().any(changed)
    };
    let mut shown = Vec::new();
    let mut left_out = false;
    for (at, line) in lines_.iter().enumerate() {
        if !near(at) {
            left_out = true;
            continue;
        }
        if std::mem::take(&mut left_out) {
            shown.push(words("span class=\"kept\"", "  …"));
        }
        shown.push(match line {
            DiffLine::Kept(line) => words("span class=\"kept\"", format!("  {line}")),
            DiffLine::Added(line) => words("ins", format!("+ {line}")),
            DiffLine::Removed(line) => words("del", format!("- {line}")),
        });
    }
    let words_ = "What was added (+) to the model; the whole of it is model.yaml, which can be simulated as it is.";
    section("The model", lines([words("p", words_), tag("pre", lines(shown))]))
}
