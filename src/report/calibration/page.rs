//! `report.html` of a calibration: one self-contained page.

use maud::{Markup, html};

use super::{CalibrationReport, DRAWINGS};
use crate::data::calibration::{
    CalibratedNumber, CalibrationFindings, HeldOutError, ResidualGroup,
};
use crate::report::ReportError;
use crate::report::discovery::format::{millimetres, number};
use crate::report::html::{captioned, cells, document, figure, list, section, table};

/// Groups of a kind in the table.
const MAX_GROUPS: usize = 12;

/// The page.
///
/// # Errors
/// [`ReportError::Draw`] when a figure cannot be painted.
pub(super) fn page(report: &CalibrationReport) -> Result<String, ReportError> {
    let [errors, map] = DRAWINGS.map(|(name, draw)| figure(name, |width| draw(report, width)));
    let findings = report.findings;
    let content = html! {
        (head(findings))
        (section("Error on positions not used in the fit", &unseen(findings.held_out.as_ref(), &errors?)))
        (section("Limitations", &list(&findings.limitations)))
        (section("Numbers", &numbers(findings)))
        (section("Selection", &stages(findings)))
        (section("Error by region", &places(findings, &map?)))
    };
    Ok(document("Calibration", &content))
}

/// Title and the numbers that matter most.
fn head(findings: &CalibrationFindings) -> Markup {
    let unseen = findings.held_out.as_ref().and_then(|held_out| held_out.models.first());
    let tile = |name: &str, value: String, note: &str| html! { div { dt { (name) } dd { (value) } dd .note { (note) } } };
    html! {
        header {
            h1 { (findings.numbers.len()) " numbers fitted to " (findings.positions) " positions" }
            dl .tiles {
                (tile("Before", millimetres(findings.before_m), "rms error of the model as given"))
                (tile("After", millimetres(findings.after_m), "rms error on the rows of the fit"))
                @if let Some(model) = unseen {
                    (tile("Unseen", millimetres(model.rms_m), "rms error on rows not used in the \
                                                               fit"))
                }
                @if let Some(noise) = &findings.noise { (tile("Noise", millimetres(noise.noise_m), &noise.from)) }
            }
        }
    }
}

fn unseen(held_out: Option<&HeldOutError>, errors: &Markup) -> Markup {
    let Some(held_out) = held_out else { return Markup::default() };
    let mut header = vec!["Model", "Numbers", "All"];
    let several = held_out.points.len() > 1;
    if several {
        header.extend(held_out.points.iter().map(String::as_str));
    }
    let row = |model: &crate::data::calibration::ModelError| {
        let count = if model.numbers > 0 { model.numbers.to_string() } else { "–".to_owned() };
        let mut texts = vec![model.name.clone(), count, millimetres(model.rms_m)];
        if several {
            texts.extend(model.by_point_m.iter().map(|&size| millimetres(size)));
        }
        cells(texts)
    };
    let rows: Vec<Vec<Markup>> = held_out.models.iter().map(row).collect();
    let names = held_out.names.join(", ");
    html! {
        (captioned(errors, "Root mean square distance between predicted and measured positions. \
                            Dashed: noise of the measurement."))
        (table(&header, &rows))
        p .note { "How: " (held_out.how) ". " @if !names.is_empty() { "Held out: " (names) "." } }
    }
}

fn numbers(findings: &CalibrationFindings) -> Markup {
    let row = |fitted: &CalibratedNumber| {
        let prior = fitted.prior_deviation.map_or_else(|| "–".to_owned(), |size| number(size, 3));
        let interval = if fitted.determined {
            format!("{} to {}", size(fitted.low), size(fitted.high))
        } else {
            "not determined".to_owned()
        };
        let unit = if fitted.unit == "1" { "" } else { &fitted.unit };
        let numbers = cells([unit, &size(fitted.start), &size(fitted.value), &interval, &prior]);
        [vec![html! { code { (fitted.name) } }], numbers].concat()
    };
    let rows: Vec<Vec<Markup>> = findings.numbers.iter().map(row).collect();
    let pairs: Vec<Vec<Markup>> = findings
        .trade_offs
        .iter()
        .map(|pair| {
            let correlation = number(pair.correlation, 3);
            vec![
                html! { code { (pair.first) } },
                html! { code { (pair.second) } },
                html! { (correlation) },
            ]
        })
        .collect();
    html! {
        (table(&["Number", "Unit", "Start", "Value", "95 % interval", "Prior ±"], &rows))
        @if !pairs.is_empty() {
            p { "The estimates of these pairs are strongly correlated: the recording determines \
                 each of a pair poorly." }
            (table(&["Number", "with", "Correlation"], &pairs))
        }
    }
}

/// A value of any size.
fn size(value: f64) -> String {
    let readable = value == 0.0 || (1e-3..1e5).contains(&value.abs());
    if readable || !value.is_finite() { number(value, 4) } else { format!("{value:.3e}") }
}

fn stages(findings: &CalibrationFindings) -> Markup {
    let row = |stage: &crate::data::calibration::FitStage| {
        let kept = if stage.kept { "kept" } else { "left out" };
        cells([
            &stage.name,
            &stage.numbers.to_string(),
            &millimetres(stage.cross_validated_m),
            kept,
        ])
    };
    let rows: Vec<Vec<Markup>> = findings.stages.iter().map(row).collect();
    html! {
        @if !rows.is_empty() {
            p { "Numbers are added in groups. A group is kept only if it lowers the \
                 cross-validated error." }
            (table(&["Group", "Numbers with it", "Cross-validated error", ""], &rows))
        }
    }
}

fn places(findings: &CalibrationFindings, map: &Markup) -> Markup {
    let mut kinds: Vec<&str> =
        findings.residual_groups.iter().map(|group| group.kind.as_str()).collect();
    kinds.dedup();
    let row = |group: &&ResidualGroup| {
        let mean = [group.mean_x_m, group.mean_y_m, group.mean_z_m]
            .map(|mean| number(1e3 * mean, 3))
            .join(", ");
        cells([&group.name, &group.positions.to_string(), &millimetres(group.rms_m), &mean])
    };
    html! {
        (captioned(map, "Grey: measured. Blue: simulated with the calibrated model. A sample of \
                         positions at even intervals."))
        @for kind in kinds {
            @let rows: Vec<Vec<Markup>> = findings.residual_groups.iter().filter(|group| group.kind == kind)
                .take(MAX_GROUPS).map(|group| row(&group)).collect();
            (table(&[&format!("By {kind}"), "Positions", "rms error", "Mean error x, y, z (mm)"], &rows))
        }
        p .note { "Simulated minus measured. All groups are in residual_groups.csv." }
    }
}
