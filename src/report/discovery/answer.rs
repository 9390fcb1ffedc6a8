//! The top of the page: the verdict in words, the gap in numbers, and the effects with their
//! parameters.

use super::format::{NONE, enumerate, millimetres, percent, times};
use super::quantity::quantities;
use super::{DiscoveryReport, EffectText};
use crate::data::findings::{Findings, FoundEffect, Verdict};
use crate::report::html::{list, section, table};
use maud::{Markup, html};

/// The answer as a title.
pub(super) fn title(report: &DiscoveryReport) -> String {
    let missing: Vec<String> =
        report.findings.effects.iter().map(|effect| missing(report, effect)).collect();
    match report.findings.verdict {
        Verdict::Named if missing.is_empty() => "The model lacks an effect".to_owned(),
        Verdict::Named => format!("The model lacks: {}", missing.join("; ")),
        Verdict::Consistent => "These data show no missing effect".to_owned(),
        Verdict::Ambiguous if missing.is_empty() => {
            "An effect is missing; these data do not identify it".to_owned()
        }
        Verdict::Ambiguous => {
            "An effect is missing; these data do not determine which of several".to_owned()
        }
        Verdict::Unexplained => {
            "The model has an error that no effect of the catalogue explains".to_owned()
        }
    }
}

/// What a model without the effect lacks; its name where the catalogue says nothing.
fn missing(report: &DiscoveryReport, effect: &FoundEffect) -> String {
    let text = report.text_of(&effect.name).filter(|text| !text.missing.is_empty());
    text.map_or_else(|| effect.name.replace('_', " "), |text| text.missing.clone())
}

/// What the verdict means.
fn meaning(findings: &Findings) -> &'static str {
    match findings.verdict {
        Verdict::Named if !findings.complete => {
            "The effects below explain most of the difference between model and measurement, and \
             no other candidate explains it equally well. The remaining error is larger than that \
             of this model on this robot as built."
        }
        Verdict::Named => {
            "The effects below explain the difference between model and measurement. No other \
             candidate explains it equally well."
        }
        Verdict::Consistent => {
            "Model and measurement differ by no more than noise and the uncertainty of the model. \
             The model was not changed."
        }
        Verdict::Ambiguous => {
            "Several sets of effects explain the difference equally well. Each effect below \
             belongs to at least one of them. Another recording can distinguish them."
        }
        Verdict::Unexplained => {
            "Model and measurement differ by more than noise, and no effect of the catalogue \
             explains it. The tables and figures below show where they differ and in what pattern."
        }
    }
}

/// Verdict, summary and the gap in numbers.
pub(super) fn head(report: &DiscoveryReport) -> Markup {
    let findings = report.findings;
    let verdict = findings.verdict.name();
    html! {
        header {
            p .badge .(verdict) { "Verdict: " (verdict) }
            h1 { (title(report)) }
            @if !findings.summary.is_empty() { p .lead { (findings.summary) } }
            p { (meaning(findings)) }
            (sources(report))
            @if !findings.summary.contains(&findings.pattern) { p { strong { "Pattern: " } (findings.pattern) } }
            (tiles(report))
        }
    }
}

/// What was asked, by which version, and how to ask again.
fn sources(report: &DiscoveryReport) -> Markup {
    let sources = report.sources;
    html! {
        details .sources {
            summary {
                "Model " code { (sources.model) } ", recording " code { (sources.measured.join(", ")) }
                @if let Some(baseline) = &sources.baseline { ", baseline " code { (baseline) } }
            }
            p .note { "spinebench " (crate::VERSION) } pre { (sources.command()) }
        }
    }
}

/// The numbers that matter most.
fn tiles(report: &DiscoveryReport) -> Markup {
    let (gap, floor_m) = (&report.findings.gap, report.findings.noise_floor_m);
    let tile = |name: &str, value: String, note: String| html! { div { dt { (name) } dd { (value) } dd .note { (note) } } };
    let over = |size_m: f64| match times(size_m, floor_m) {
        ratio if ratio == NONE => String::new(),
        ratio => format!("{ratio} the noise floor"),
    };
    let mut tiles = vec![tile(
        &format!("Error of the {}", report.before()),
        millimetres(gap.before_m),
        over(gap.before_m),
    )];
    if report.changed() {
        tiles.push(tile("Error with the effects", millimetres(gap.after_m), over(gap.after_m)));
    }
    tiles.push(tile(
        "Noise floor",
        millimetres(floor_m),
        "error expected from noise alone, an estimate: a correct model can fall below it"
            .to_owned(),
    ));
    if report.changed() {
        let share = report.findings.explained_share;
        let range = |[low, high]: [f64; 2]| {
            format!(", 95 % interval {} to {}", percent(low), percent(high))
        };
        let interval = report.findings.explained_share_interval_95.map_or_else(String::new, range);
        tiles.push(tile(
            "Gap explained",
            share.map_or_else(|| NONE.to_owned(), percent),
            format!(
                "share of the squared error that is gone, of what exceeds that of the model on this \
                 robot as built{interval}"
            ),
        ));
    }
    let where_from = match gap.held_out_trials.as_slice() {
        [] => "No trial was held out: these numbers are for the data that the model was fitted to."
            .to_owned(),
        trials => {
            let numbers: Vec<String> = trials.iter().take(12).map(u64::to_string).collect();
            let more = if trials.len() > 12 {
                format!(" and {} more", trials.len() - 12)
            } else {
                String::new()
            };
            let (word, them) =
                if trials.len() == 1 { ("trial", "it was") } else { ("trials", "they were") };
            let names =
                if more.is_empty() { enumerate(&numbers, "and") } else { numbers.join(", ") };
            format!(
                "Measured on {word} {names}{more}, held out: {them} used neither for naming nor \
                 for fitting."
            )
        }
    };
    let metric =
        if gap.metric.is_empty() { String::new() } else { format!(" Error means {}.", gap.metric) };
    html! { dl .tiles { @for tile in tiles { (tile) } } p .note { (where_from) (metric) } }
}

/// Part of the squared error beyond noise that is gone; none where there was no more than noise.
pub(crate) fn closed(before_m: f64, after_m: f64, floor_m: f64) -> Option<f64> {
    let [before, after, floor] = [before_m, after_m, floor_m].map(|size| size * size);
    let share = 1.0 - (after - floor).max(0.0) / (before - floor);
    (before > floor && share.is_finite()).then_some(share)
}

/// A card for each effect of the answer.
pub(super) fn effects(report: &DiscoveryReport) -> Markup {
    let effects = &report.findings.effects;
    let heading = match (report.findings.verdict, effects.len()) {
        (Verdict::Ambiguous, _) => "Possible effects",
        (_, 1) => "Missing effect",
        _ => "Missing effects",
    };
    section(heading, &html! { @for effect in effects { (card(report, effect)) } })
}

fn card(report: &DiscoveryReport, effect: &FoundEffect) -> Markup {
    let catalogue_text = report.text_of(&effect.name);
    let rows = quantities(effect).into_iter().map(|quantity| {
        let interval =
            if quantity.interval.is_empty() { NONE.to_owned() } else { quantity.interval };
        vec![
            html! { code { (quantity.key) } },
            html! { strong { (quantity.value) } },
            html! { (interval) },
        ]
    });
    html! {
        article {
            h3 {
                @if let Some(catalogue_text) = catalogue_text.filter(|text| !text.missing.is_empty()) { span { (catalogue_text.missing) } " " }
                code { (effect.name) }
            }
            (table(&["parameter", "value", "95 % interval"], &rows.collect::<Vec<_>>()))
            (facts(effect, catalogue_text))
        }
    }
}

/// How sure, what else it could be, and what it means.
fn facts(effect: &FoundEffect, catalogue_text: Option<&EffectText>) -> Markup {
    let mut facts = Vec::new();
    if effect.confidence.is_finite() {
        let share = percent(effect.confidence);
        facts.push(
            html! { "Probability among the candidates that were fitted: " strong { (share) } },
        );
    }
    if !effect.confusable_with.is_empty() {
        facts.push(html! {
            "These data do not rule out "
            @for (index, name) in effect.confusable_with.iter().enumerate() {
                @if index > 0 { ", " }
                code { (name) }
            }
        });
    }
    if let Some(catalogue_text) = catalogue_text {
        if !catalogue_text.equation.is_empty() {
            facts.push(
                html! { "Equation: " span .equation dir="ltr" { (catalogue_text.equation) } },
            );
        }
        if !catalogue_text.source.is_empty() {
            facts.push(html! { "Source: " span { (catalogue_text.source) } });
        }
    }
    list(&facts)
}

#[cfg(test)]
mod tests {
    use super::closed;

    #[test]
    fn closing_is_measured_beyond_noise() {
        assert_eq!(closed(5.0, 3.0, 3.0), Some(1.0));
        assert_eq!(closed(5.0, 5.0, 3.0), Some(0.0));
        assert_eq!(closed(5.0, 2.0, 3.0), Some(1.0));
        assert_eq!(closed(3.0, 3.0, 3.0), None);
        assert_eq!(closed(f64::NAN, 3.0, 3.0), None);
    }
}
