//! A changed robot and its repair: the error of goal reaching before, after, and mended in several
//! ways, one panel a change.

use super::repair_table::{VARIANTS, markdown, summary_rows};
use crate::math::summary::mean;
use crate::report::cells::modes_in_order;
use crate::report::drawing::{Axis, Canvas, LegendEntry, Panel, Text, TextAlign, legend};
use crate::report::order::{distinct, last_training};
use crate::report::style::{
    DOTTED, GREY, LINE, PAGE_WIDTH, SMALL, TEXT, capitalised, mode_title, policies_in_order,
    policy_label, policy_look, training_label,
};
use crate::report::{Artifact, Figure, Published, ReportError, csv, text};
use crate::rows::repairs::{RepairRow, RepairSummaryRow};

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "repair",
    about: "A robot that changed: error before, after, repaired, and with new data, by change",
    render,
};

/// Panels in a line.
const COLUMNS: usize = 3;

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    FIGURE.needs("repair_trials.csv", published.repair_trials.is_empty())?;
    let rows = summary_rows(&published.repair_trials, &published.repairs);
    FIGURE.files(
        vec![csv("repair_summary.csv", &rows)?, text("repair.md", markdown(&rows, published))],
        &draw(&rows, &published.repairs),
    )
}

/// The panels of the last kind of training: networks are at their best there.
fn draw(rows: &[RepairSummaryRow], repairs: &[RepairRow]) -> Canvas {
    let training = last_training(rows.iter().map(|row| row.training.as_str()));
    let rows: Vec<&RepairSummaryRow> = rows.iter().filter(|row| row.training == training).collect();
    let modes = modes_in_order(rows.iter().map(|row| row.cell.mode.as_str()));
    let changes = distinct(rows.iter().map(|row| row.change.as_str()));
    let lines = changes.len().div_ceil(COLUMNS);
    let (left, gap, high, pitch, head) = (50.0, 16.0, 120.0, 188.0, 28.0);
    let width = (PAGE_WIDTH - left - 12.0 - gap * (COLUMNS - 1) as f64) / COLUMNS as f64;
    let block = head + pitch * lines as f64;
    let keys: Vec<(LegendEntry, &str)> =
        policies_in_order(rows.iter().map(|row| row.cell.policy.as_str()))
            .into_iter()
            .map(|policy| (LegendEntry::Plain(policy_look(policy)), policy_label(policy)))
            .collect();
    let mut canvas = Canvas::new(PAGE_WIDTH, 73.0 + block * modes.len() as f64);
    let base = legend(&mut canvas, [left, 16.0], PAGE_WIDTH - 8.0, &keys);
    let note = format!(
        "before the change, after it, repaired, with moved points, with new points, with new data; \
         means; {}",
        training_label(training)
    );
    let dotted = "dotted: the nearest place to the target where the tip of the changed robot comes \
                  to rest, mean";
    for (line, text) in [note.as_str(), dotted].into_iter().enumerate() {
        let below = base + 17.0 + 13.0 * line as f64;
        canvas.text(Text::new(text, [left, below], SMALL, TextAlign::Left).colour(GREY));
    }
    let nearest = changes.iter().map(|change| nearest_mm(repairs, change));
    let means_mm = rows.iter().map(|row| 1e3 * row.mean_m).chain(nearest);
    let y = Axis::covering("error (mm)", means_mm.chain([0.0]), 4);
    let names: Vec<String> = VARIANTS.0.iter().map(|(_, short)| (*short).to_owned()).collect();
    for (number, mode) in modes.iter().enumerate() {
        let top = base + 43.0 + block * number as f64;
        canvas.text(
            Text::new(capitalised(&mode_title(mode)), [left, top + 14.0], TEXT, TextAlign::Left)
                .bold(),
        );
        for (place, change) in changes.iter().enumerate() {
            let (line, column) = (place / COLUMNS, place % COLUMNS);
            let corner =
                [left + column as f64 * (width + gap), top + head + 12.0 + pitch * line as f64];
            let y = if column == 0 { y.clone() } else { y.bare() };
            let panel_rows: Vec<&RepairSummaryRow> = rows
                .iter()
                .copied()
                .filter(|row| row.cell.mode == *mode && row.change == *change)
                .collect();
            let (size, x) = ([width, high], Axis::categories("", &names));
            let panel = canvas.panel(Panel { corner, size, x, y, title: change.replace('_', " ") });
            series(&mut canvas, &panel, &panel_rows);
            let nearest_mm = nearest_mm(repairs, change);
            if nearest_mm.is_finite() {
                let ends = [0.6, VARIANTS.0.len() as f64 - 0.6].map(|x| [x, nearest_mm]);
                panel.line(&mut canvas, &ends, GREY, DOTTED, LINE);
            }
        }
    }
    canvas
}

/// How near a changed robot can come to the targets, mean over repetitions, millimetres.
fn nearest_mm(repairs: &[RepairRow], change: &str) -> f64 {
    let of_change =
        repairs.iter().filter(|row| row.change == change).map(|row| 1e3 * row.nearest_m);
    mean(&of_change.filter(|nearest_mm| nearest_mm.is_finite()).collect::<Vec<f64>>())
}

/// Draws the errors in one mode after one change.
fn series(canvas: &mut Canvas, panel: &Panel, rows: &[&RepairSummaryRow]) {
    for policy in policies_in_order(rows.iter().map(|row| row.cell.policy.as_str())) {
        let at = |(place, (variant, _)): (usize, &(&str, &str))| {
            let row =
                rows.iter().find(|row| row.cell.policy == policy && row.variant == *variant)?;
            row.mean_m.is_finite().then_some([place as f64, 1e3 * row.mean_m, f64::NAN])
        };
        let points: Vec<[f64; 3]> = VARIANTS.0.iter().enumerate().filter_map(at).collect();
        panel.series(canvas, &points, policy_look(policy));
    }
}
