//! What tells controllers apart: error against time, and error against the speed of a path, by
//! policy and mode. Errors are those of the tip without tracking noise, where the robot is
//! simulated.

use std::collections::BTreeMap;

use super::controllers_table::{controller_rows, markdown};
use crate::math::summary::mean;
use crate::report::cells::modes_in_order;
use crate::report::drawing::{Axis, Canvas, LegendEntry, Panel, Text, TextAlign, legend};
use crate::report::order::{ascending, last_training};
use crate::report::style::{
    GREY, PAGE_WIDTH, SMALL, mode_title, policies_in_order, policy_label, policy_look,
    training_label,
};
use crate::report::{Artifact, Figure, Published, ReportError, csv, text};
use crate::rows::responses::{ControllerRow, PaceRow};

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "controllers",
    about: "Controllers told apart: error against time, and path tracking against speed",
    render,
};

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    FIGURE.needs("responses.csv", published.responses.is_empty())?;
    let rows = controller_rows(&published.responses);
    FIGURE.files(
        vec![
            csv("controllers.csv", &rows)?,
            text("controllers.md", markdown(&rows, &published.paces)),
        ],
        &draw(&rows, &published.paces),
    )
}

/// One panel: a title, its columns, and for each policy the errors over the columns, millimetres.
struct Curves<'a> {
    title: String,
    axis: &'a str,
    columns: Vec<String>,
    curves: Vec<(&'a str, Vec<f64>)>,
}

/// The panels of the last kind of training: networks are at their best there.
fn draw(rows: &[ControllerRow], paces: &[PaceRow]) -> Canvas {
    let training = last_training(rows.iter().map(|row| row.training.as_str()));
    let rows: Vec<&ControllerRow> = rows.iter().filter(|row| row.training == training).collect();
    let paces: Vec<&PaceRow> =
        paces.iter().filter(|row| row.training == training && row.status.is_ok()).collect();
    let modes = rows
        .iter()
        .map(|row| row.cell.mode.as_str())
        .chain(paces.iter().map(|row| row.cell.mode.as_str()));
    let modes = modes_in_order(modes);
    let in_time = modes.iter().filter_map(|mode| in_time(&rows, mode));
    let panels: Vec<Curves> =
        in_time.chain(modes.iter().filter_map(|mode| over_speed(&paces, mode))).collect();
    let policies = policies_in_order(rows.iter().map(|row| row.cell.policy.as_str()));
    let (left, gap, high, pitch) = (56.0, 62.0, 170.0, 240.0);
    let width = (PAGE_WIDTH - left - 12.0 - gap) / 2.0;
    let keys: Vec<(LegendEntry, &str)> = policies
        .iter()
        .map(|policy| (LegendEntry::Plain(policy_look(policy)), policy_label(policy)))
        .collect();
    let mut canvas = Canvas::new(PAGE_WIDTH, 88.0 + pitch * panels.len().div_ceil(2) as f64);
    let base = legend(&mut canvas, [left, 16.0], PAGE_WIDTH - 8.0, &keys);
    let note = format!(
        "means over targets and repetitions, error of the true tip; {}",
        training_label(training)
    );
    canvas.text(Text::new(&note, [left, base + 17.0], SMALL, TextAlign::Left).colour(GREY));
    let all = panels.iter().flat_map(|panel| panel.curves.iter().flat_map(|curve| curve.1.clone()));
    let y = Axis::decades("error (mm)", all.filter(|error_mm| *error_mm > 0.0));
    for (place, curves) in panels.iter().enumerate() {
        let (line, column) = (place / 2, place % 2);
        let corner = [left + column as f64 * (width + gap), base + 46.0 + pitch * line as f64];
        panel(&mut canvas, curves, corner, [width, high], &y);
    }
    canvas
}

fn panel(canvas: &mut Canvas, curves: &Curves, corner: [f64; 2], size: [f64; 2], y: &Axis) {
    let x = Axis::categories(curves.axis, &curves.columns);
    let panel = canvas.panel(Panel { corner, size, x, y: y.clone(), title: curves.title.clone() });
    for (policy, errors_mm) in &curves.curves {
        let points: Vec<[f64; 3]> = errors_mm
            .iter()
            .enumerate()
            .filter(|(_, error_mm)| error_mm.is_finite() && **error_mm > 0.0)
            .map(|(place, error_mm)| [place as f64, error_mm.log10(), f64::NAN])
            .collect();
        panel.series(canvas, &points, policy_look(policy));
    }
}

fn in_time<'a>(rows: &[&'a ControllerRow], mode: &str) -> Option<Curves<'a>> {
    let rows: Vec<&&ControllerRow> = rows.iter().filter(|row| row.cell.mode == mode).collect();
    let errors = |row: &ControllerRow| {
        [row.error_1s_m, row.error_2s_m, row.error_5s_m, row.error_end_m].map(|m| 1e3 * m)
    };
    let curves: Vec<(&str, Vec<f64>)> =
        rows.iter().map(|row| (row.cell.policy.as_str(), errors(row).to_vec())).collect();
    let columns = ["1 s", "2 s", "5 s", "end"].map(str::to_owned).to_vec();
    (!curves.is_empty()).then(|| Curves {
        title: mode_title(mode),
        axis: "time since the start",
        columns,
        curves,
    })
}

fn over_speed<'a>(paces: &[&'a PaceRow], mode: &str) -> Option<Curves<'a>> {
    let rows: Vec<&&PaceRow> = paces.iter().filter(|row| row.cell.mode == mode).collect();
    let speeds = ascending(rows.iter().map(|row| row.speed));
    let mut by_policy: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for row in &rows {
        by_policy.entry(row.cell.policy.as_str()).or_insert_with(|| {
            let at = |speed: &f64| {
                let same_runs = rows
                    .iter()
                    .filter(|other| other.cell.policy == row.cell.policy && other.speed == *speed);
                1e3 * mean(&same_runs.map(|other| other.rms_m).collect::<Vec<_>>())
            };
            speeds.iter().map(at).collect()
        });
    }
    let columns = speeds.iter().map(|speed| format!("{speed}×")).collect();
    let title = format!("path, {}", mode_title(mode));
    let curves: Vec<(&str, Vec<f64>)> = by_policy.into_iter().collect();
    (!curves.is_empty()).then_some(Curves {
        title,
        axis: "speed of the path (rms error)",
        columns,
        curves,
    })
}
