//! The middle of the page: where model and measurement disagree, and the proof that the answer
//! closes the gap.

use super::DiscoveryReport;
use super::answer::closed;
use super::format::{NONE, enumerate, millimetres, number, percent, probability, times};
use super::residuals::{AXES, held_out};
use super::scale::{SIGNIFICANCE_LEVEL, marked};
use crate::data::findings::{Findings, MissingTest, ResidualRow, Verdict};
use crate::math::summary::root_mean_square;
use crate::report::html::{captioned, cells, section, table};
use crate::report::scene::player;
use maud::{Markup, html};

/// Rows of a table; the rest is in the files beside the page.
const MAX_ROWS: usize = 12;

/// The robot on a held-out trial.
pub(super) fn robot(report: &DiscoveryReport) -> Markup {
    let note = "Simulation of one held-out trial. The diamond is the measured tip; the dotted line \
                connects it to the simulated tip.";
    let shown = player("The robot on a held-out trial", report.scenes);
    let content = html! { @if !shown.0.is_empty() { p .note { (note) } (shown) } };
    section("Model and measurement in motion", &content)
}

/// Where they disagree.
pub(super) fn place(report: &DiscoveryReport, map: &Markup) -> Markup {
    let findings = report.findings;
    let caption = "Each number is the rms residual (measured minus model) at a place along an \
                   axis, divided by the noise floor: 1 is noise. The views show the workspace of \
                   the robot, with z to the right.";
    let rows = findings.disagreement.iter().take(MAX_ROWS).map(|place| {
        let p = probability(place.p_value);
        let is_marked = marked(findings)[0] && place.p_value < SIGNIFICANCE_LEVEL;
        vec![
            html! { (place.place) },
            html! { @if place.axis == "all" { "distance" } @else { (place.axis) } },
            html! { (millimetres(place.rms_m)) },
            html! { (times(place.rms_m, floor_m(findings, &place.axis))) },
            html! { (percent(place.share)) },
            html! { @if is_marked { strong { (p) } } @else { (p) } },
        ]
    });
    let header = ["place", "axis", "residual, rms", "over the floor", "share of all squares", "p"];
    let places = table(&header, &rows.collect::<Vec<_>>());
    let note = "p: probability of a residual of this size from noise alone, corrected for the \
                number of places.";
    let content = html! {
        (captioned(map, caption))
        (places)
        @if !places.0.is_empty() { p .note { (note) } }
        (noise(report))
    };
    section("Where model and measurement differ", &content)
}

/// What noise alone makes along this axis, or of the distance.
fn floor_m(findings: &Findings, axis: &str) -> f64 {
    match AXES.iter().position(|name| *name == axis) {
        Some(axis) => findings.noise.sigma_m[axis],
        None => findings.noise_floor_m,
    }
}

/// What was taken for noise.
fn noise(report: &DiscoveryReport) -> Markup {
    let noise = &report.findings.noise;
    let sizes: Vec<String> = noise.sigma_m.iter().map(|sigma| number(1e3 * sigma, 2)).collect();
    let from = if noise.from.is_empty() {
        String::new()
    } else {
        format!(", estimated from {}", noise.from)
    };
    let note = format!(
        "Noise: standard deviation {} mm along x, y and z, correlation {} from one sample to the \
         next{from}.",
        enumerate(&sizes, "and"),
        number(noise.correlation, 2),
    );
    html! { p .note { (note) } }
}

/// Gap, residuals, the test for more, and each held-out trial.
pub(super) fn proof(report: &DiscoveryReport, gap: &Markup, residuals: &Markup) -> Markup {
    let bars = "Rms distance between measured and simulated positions, over all tracked places. \
                Dashed: noise floor.";
    let curves = "Measured minus model at the tip on held-out trials.";
    let heading = if report.changed() { "Held-out test" } else { "Size of the error" };
    let content = html! { (captioned(gap, bars)) (captioned(residuals, curves)) (trials(report)) (missing(report)) };
    section(heading, &content)
}

/// A row for each held-out trial.
fn trials(report: &DiscoveryReport) -> Markup {
    let held_out = held_out(report.residuals);
    let floor_m = report.findings.noise_floor_m;
    let changed = report.changed();
    let rows = held_out.iter().map(|(trial, rows)| {
        let (before, after) =
            (rms_m(rows, ResidualRow::before_m), rms_m(rows, ResidualRow::after_m));
        let mut texts = vec![trial.to_string(), rows.len().to_string(), millimetres(before)];
        if changed {
            let share = closed(before, after, floor_m).map_or_else(|| NONE.to_owned(), percent);
            texts.extend([millimetres(after), times(after, floor_m), share]);
        }
        cells(texts)
    });
    let header =
        ["held-out trial", "samples", "before", "after", "after over the floor", "gap closed"];
    let table = table(&header[..if changed { 6 } else { 3 }], &rows.collect::<Vec<_>>());
    let note = "Gap closed: share of the squared error above the noise floor that is gone. “Gap \
                explained” at the top counts from the error of the model on this robot as built in \
                place of the noise floor.";
    html! { (table) @if changed && !table.0.is_empty() { p .note { (note) } } }
}

/// Root mean square of the distance; samples without one are left out.
fn rms_m(rows: &[&ResidualRow], residual: fn(&ResidualRow) -> [f64; 3]) -> f64 {
    let sizes =
        rows.iter().map(|row| residual(row).iter().map(|part| part * part).sum::<f64>().sqrt());
    root_mean_square(&sizes.filter(|size| size.is_finite()).collect::<Vec<_>>())
}

/// Is anything missing, before and after?
fn missing(report: &DiscoveryReport) -> Markup {
    let row = |name: &str, test: &MissingTest, more: bool| {
        let verdict = match test.p_value {
            p if !p.is_finite() => NONE,
            _ if more => "yes",
            _ => "no evidence",
        };
        let sizes = [millimetres(test.foretold_m), probability(test.p_value)];
        let cells = cells(std::iter::once(name.to_owned()).chain(sizes));
        [cells, vec![html! { strong { (verdict) } }]].concat()
    };
    // More tests than this one decide, and how much it would be: the verdict has them all.
    let verdict = report.findings.verdict;
    let mut rows = vec![row(
        if report.calibrated { "as calibrated" } else { "as given" },
        &report.findings.missing_before,
        verdict != Verdict::Consistent,
    )];
    if report.changed() {
        rows.push(row(
            "with the effects",
            &report.findings.missing_after,
            verdict == Verdict::Unexplained,
        ));
    }
    let question = "Is the residual noise? The table shows the cross-trial test: noise cannot be \
                    predicted from other trials. Five further tests check the variance, \
                    differences between trials, means of repeated measurements, small amounts of \
                    all effects together, and growth with the effects’ displacement. The last \
                    column is the verdict of all tests.";
    let header = ["model", "predicted by other trials", "p", "effect missing?"];
    html! { p { (question) } (table(&header, &rows)) }
}
