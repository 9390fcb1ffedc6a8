//! A population of robots: the error of each policy over robots, and the share of robots on which
//! each claim holds.

use super::population_table::{attribution_rows, markdown, population_rows};
use crate::report::cells::modes_in_order;
use crate::report::drawing::{Axis, Canvas, Panel, Text, TextAlign};
use crate::report::order::last_training;
use crate::report::style::{
    GREY, HAIR, HALF_CAP, INK, LEFT_MARGIN, MARKER, Marker, PAGE_WIDTH, SMALL, TALL, TEXT,
    claim_label, mode_title, policies_in_order, policy_label, policy_look, training_label,
};
use crate::report::{Artifact, Figure, Published, ReportError, csv, text};
use crate::rows::population::{PopulationRow, RobotClaimRow};

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "population",
    about: "Many robots: the error of each policy over them, and the share on which each claim \
            holds",
    render,
};

/// Height of a panel of errors, distance from one to the next, and height of the line of a claim.
const PANEL_HEIGHT: f64 = 150.0;
const PANEL_PITCH: f64 = 206.0;
const CLAIM_HEIGHT: f64 = 19.0;
/// Left edge of the panel of claims, beside their names.
const CLAIMS_LEFT: f64 = 410.0;

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    FIGURE.needs(
        "robots.csv and trials.csv",
        published.robots.is_empty() || published.trials.is_empty(),
    )?;
    let rows = population_rows(&published.trials);
    let effects = attribution_rows(&published.trials, &published.robots);
    let claims = &published.robot_claims;
    let mut files = vec![
        csv("population.csv", &rows)?,
        text("population.md", markdown(&rows, claims, &effects)),
    ];
    // Of few robots no effect can be told.
    if !effects.is_empty() {
        files.push(csv("attribution.csv", &effects)?);
    }
    FIGURE.files(files, &draw(&rows, claims))
}

/// Panels of the last kind of training: networks are at their best there.
fn draw(rows: &[PopulationRow], claims: &[RobotClaimRow]) -> Canvas {
    let training = last_training(rows.iter().map(|row| row.training.as_str()));
    let rows: Vec<&PopulationRow> = rows.iter().filter(|row| row.training == training).collect();
    let claims: Vec<&RobotClaimRow> =
        claims.iter().filter(|row| row.training == training).collect();
    let modes = modes_in_order(rows.iter().map(|row| row.cell.mode.as_str()));
    let policies = policies_in_order(rows.iter().map(|row| row.cell.policy.as_str()));
    let robots = rows.iter().map(|row| row.robots).max().unwrap_or(0);
    let mut canvas = Canvas::new(PAGE_WIDTH, TALL);
    let note = format!(
        "{robots} robots; marks: median, thick: half of all robots, thin: 90 %, hollow: the worst \
         robot; {}",
        training_label(training)
    );
    canvas.text(Text::new(&note, [LEFT_MARGIN, 18.0], SMALL, TextAlign::Left).colour(GREY));
    let y = Axis::decades(
        "error (mm)",
        rows.iter().flat_map(|row| [1e3 * row.p05_m, 1e3 * row.largest_m]),
    );
    let width = PAGE_WIDTH - LEFT_MARGIN - 12.0;
    let mut top = 46.0;
    for mode in &modes {
        let names: Vec<String> =
            policies.iter().map(|policy| policy_label(policy).to_owned()).collect();
        let panel = canvas.panel(Panel {
            corner: [LEFT_MARGIN, top],
            size: [width, PANEL_HEIGHT],
            x: Axis::categories("", &names),
            y: y.clone(),
            title: mode_title(mode),
        });
        for (place, policy) in policies.iter().enumerate() {
            if let Some(row) =
                rows.iter().find(|row| row.cell.policy == *policy && row.cell.mode == *mode)
            {
                spread(&mut canvas, &panel, place as f64, row);
            }
        }
        top += PANEL_PITCH;
    }
    if !claims.is_empty() {
        top = shares(&mut canvas, &claims, top);
    }
    canvas.height = (top + 6.0).round();
    canvas
}

/// The errors of one policy over robots.
fn spread(canvas: &mut Canvas, panel: &Panel, x: f64, row: &PopulationRow) {
    let look = policy_look(&row.cell.policy);
    let at = |error_m: f64| panel.at(x, (1e3 * error_m).log10());
    if !(row.p05_m > 0.0 && row.largest_m.is_finite()) {
        return;
    }
    canvas.line(&[at(row.p05_m), at(row.p95_m)], 1.4, look.colour, &[]);
    canvas.line(&[at(row.p25_m), at(row.p75_m)], 5.0, look.colour, &[]);
    canvas.marker(at(row.largest_m), Marker::Diamond, MARKER, look.colour, true);
    canvas.marker(at(row.median_m), look.marker, MARKER, look.colour, false);
    let label = format!("{:.1}", 1e3 * row.median_m);
    let [left, middle] = at(row.median_m);
    canvas.text(Text::new(label, [left + 9.0, middle + HALF_CAP * SMALL], SMALL, TextAlign::Left));
}

/// The share of robots on which each claim holds, below `top`; returns where it ends.
fn shares(canvas: &mut Canvas, claims: &[&RobotClaimRow], top: f64) -> f64 {
    let high = CLAIM_HEIGHT * claims.len() as f64;
    let rows = Axis::bare_to(claims.len() as f64);
    let axis = Axis::exact("share of robots on which the claim holds (%)", 0.0, 100.0, 4);
    let size = [PAGE_WIDTH - CLAIMS_LEFT - 60.0, high];
    let panel = canvas.panel(Panel {
        corner: [CLAIMS_LEFT, top],
        size,
        x: axis,
        y: rows,
        title: String::new(),
    });
    canvas.text(Text::new("Claims of the paper", [12.0, top - 8.0], TEXT, TextAlign::Left).bold());
    for (index, row) in claims.iter().enumerate() {
        let y = claims.len() as f64 - index as f64 - 0.5;
        let at = |share: f64| panel.at(100.0 * share, y);
        canvas.line(&[at(row.low_95), at(row.high_95)], 1.8, INK, &[]);
        canvas.marker(at(row.share), Marker::Circle, MARKER, INK, false);
        let base = at(0.0)[1] + HALF_CAP * SMALL;
        canvas.text(Text::new(
            claim_label(&row.claim),
            [CLAIMS_LEFT - 8.0, base],
            SMALL,
            TextAlign::Right,
        ));
        let label = format!("{} of {}", row.held, row.robots);
        canvas.text(Text::new(label, [PAGE_WIDTH - 52.0, base], SMALL, TextAlign::Left));
    }
    canvas.line(&[panel.at(50.0, 0.0), panel.at(50.0, claims.len() as f64)], HAIR, GREY, &[]);
    top + high + 44.0
}
