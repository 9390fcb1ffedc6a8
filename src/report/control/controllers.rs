//! What tells controllers apart: error against time, and error against the speed of a path, by
//! policy and mode. Errors are those of the tip without tracking noise, where the robot is
//! simulated.

use super::controllers_table::{controller_rows, markdown};
use crate::math::summary::mean;
use crate::report::cells::modes_in_order;
use crate::report::drawing::{
    Axis, Canvas, Dot, DotChart, DotPanel, DotRow, LegendEntry, MIN_PANEL, legend,
};
use crate::report::order::{ascending, last_training};
use crate::report::style::{
    LOOKS, Look, TALL, capitalised, mode_title, policies_in_order, policy_label, training_label,
};
use crate::report::{Artifact, Figure, Published, ReportError, csv, text};
use crate::rows::responses::{ControllerRow, PaceRow};

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "controllers",
    about: "Comparison of controllers: error against time, and path tracking against speed",
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
        &caption(&rows, &published.paces),
        |width| draw(&rows, &published.paces, width),
    )
}

fn caption(rows: &[ControllerRow], paces: &[PaceRow]) -> String {
    let training = last_training(rows.iter().map(|row| row.training.as_str()));
    let seeds = rows.iter().map(|row| row.seeds).max().unwrap_or(0);
    let trials = rows.iter().map(|row| row.trials).max().unwrap_or(0);
    let path = if paces.is_empty() {
        ""
    } else {
        " On the path, the mark is the root mean square distance from the moving target at 1, 2 and \
         4 times the speed."
    };
    format!(
        "Error of the true tip of each controller 1, 2 and 5 s after the start and at the end of a \
         trial, in mm on a logarithmic axis, by mode; {}. Marks are means over {trials} trials in \
         {seeds} repetitions.{path}",
        training_label(training)
    )
}

/// What the dots of a panel differ in: names, and the errors of each policy, millimetres.
struct PanelErrors<'a> {
    title: String,
    names: Vec<String>,
    errors_mm: Vec<(&'a str, Vec<f64>)>,
}

/// The panels of the last kind of training: networks are at their best there.
fn draw(rows: &[ControllerRow], paces: &[PaceRow], width: f64) -> Canvas {
    let training = last_training(rows.iter().map(|row| row.training.as_str()));
    let rows: Vec<&ControllerRow> = rows.iter().filter(|row| row.training == training).collect();
    let paces: Vec<&PaceRow> =
        paces.iter().filter(|row| row.training == training && row.status.is_ok()).collect();
    let of_rows = rows.iter().map(|row| row.cell.mode.as_str());
    let modes = modes_in_order(of_rows.chain(paces.iter().map(|row| row.cell.mode.as_str())));
    let times: Vec<PanelErrors> = modes.iter().filter_map(|mode| in_time(&rows, mode)).collect();
    let speeds: Vec<PanelErrors> =
        modes.iter().filter_map(|mode| over_speed(&paces, mode)).collect();
    let policies = policies_in_order(rows.iter().map(|row| row.cell.policy.as_str()));
    let mut canvas = Canvas::new(width, TALL);
    let mut below = 4.0;
    for panels in [times, speeds].iter().filter(|panels| !panels.is_empty()) {
        let keys: Vec<(LegendEntry, &str)> = looks()
            .zip(panels[0].names.iter())
            .map(|(look, name)| (key(look), name.as_str()))
            .collect();
        let base = legend(&mut canvas, [10.0, below + 14.0], width - 8.0, &keys);
        let chart = DotChart {
            rows: policies
                .iter()
                .map(|name| DotRow::Named(policy_label(name).to_owned(), 1))
                .collect(),
            lane_height: 14.0,
            min_panel: MIN_PANEL,
            aside: 0.0,
            panels: panels.iter().map(|panel| dots(panel, &policies)).collect(),
        };
        below = chart.draw(&mut canvas, base + 30.0);
    }
    canvas.height = below.round();
    canvas
}

fn looks() -> impl Iterator<Item = Look> {
    LOOKS.into_iter()
}

fn key(look: Look) -> LegendEntry {
    LegendEntry::Marker(look.marker, look.colour, false)
}

fn dots(panel: &PanelErrors, policies: &[&str]) -> DotPanel {
    let all = panel.errors_mm.iter().flat_map(|(_, errors_mm)| errors_mm.iter().copied());
    let dots = panel.errors_mm.iter().flat_map(|(policy, errors_mm)| {
        let row = policies.iter().position(|name| name == policy).unwrap_or(0);
        let shown = errors_mm.iter().zip(looks()).filter(|(error_mm, _)| **error_mm > 0.0);
        shown.map(move |(error_mm, look)| {
            Dot::new(row, 0, error_mm.log10(), look.marker, look.colour)
        })
    });
    DotPanel {
        title: panel.title.clone(),
        x: Axis::log("error (mm)", all, 150.0),
        dots: dots.filter(|dot| dot.value.is_finite()).collect(),
        joined: true,
        goals: Vec::new(),
    }
}

fn in_time<'a>(rows: &[&'a ControllerRow], mode: &str) -> Option<PanelErrors<'a>> {
    let rows: Vec<&&ControllerRow> = rows.iter().filter(|row| row.cell.mode == mode).collect();
    let errors = |row: &ControllerRow| {
        [row.error_1s_m, row.error_2s_m, row.error_5s_m, row.error_end_m].map(|m| 1e3 * m)
    };
    let errors_mm: Vec<(&str, Vec<f64>)> =
        rows.iter().map(|row| (row.cell.policy.as_str(), errors(row).to_vec())).collect();
    let names = ["after 1 s", "2 s", "5 s", "at the end"].map(str::to_owned).to_vec();
    (!errors_mm.is_empty()).then(|| PanelErrors {
        title: capitalised(&mode_title(mode)),
        names,
        errors_mm,
    })
}

fn over_speed<'a>(paces: &[&'a PaceRow], mode: &str) -> Option<PanelErrors<'a>> {
    let rows: Vec<&&PaceRow> = paces.iter().filter(|row| row.cell.mode == mode).collect();
    let speeds = ascending(rows.iter().map(|row| row.speed));
    let policies = policies_in_order(rows.iter().map(|row| row.cell.policy.as_str()));
    let errors = |policy: &str| {
        let at = |speed: &f64| {
            let same_runs =
                rows.iter().filter(|row| row.cell.policy == policy && row.speed == *speed);
            1e3 * mean(&same_runs.map(|row| row.rms_m).collect::<Vec<_>>())
        };
        speeds.iter().map(at).collect()
    };
    let errors_mm: Vec<(&str, Vec<f64>)> =
        policies.into_iter().map(|policy| (policy, errors(policy))).collect();
    let names = speeds.iter().map(|speed| format!("path at {speed}× speed")).collect();
    let title = format!("Path, {}", mode_title(mode));
    (!errors_mm.is_empty()).then_some(PanelErrors { title, names, errors_mm })
}
