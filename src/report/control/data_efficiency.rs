//! How many real points a policy needs: error of the true tip against the number of points that its
//! Gaussian process, or its network, has seen; and the points from which on the error stays within
//! 5, 3 and 2 mm.

use super::controllers_table::{controller_rows, mm};
use crate::report::cells::modes_in_order;
use crate::report::drawing::{Axis, Canvas, LineEnd, Panel, ends_width, name_ends, thousands};
use crate::report::order::{distinct, last_training, trainings};
use crate::report::page::markup::MarkdownTable;
use crate::report::style::{
    HAIR, LEFT_MARGIN, NARROW, TALL, capitalised, mode_title, policies_in_order, policy_label,
    policy_look, policy_markdown, training_label,
};
use crate::report::{Artifact, Figure, Published, ReportError, csv, text};
use crate::rows::responses::{ControllerRow, PointsNeededRow};

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "data_efficiency",
    about: "Error against the number of real points, for every policy, and the points that it \
            takes",
    render,
};

/// Errors that are asked for, metres.
const WANTED_M: [f64; 3] = [0.005, 0.003, 0.002];

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    FIGURE.needs("responses.csv", published.responses.is_empty())?;
    let rows = controller_rows(&published.responses);
    let needed = points_needed(&rows);
    FIGURE.files(
        vec![
            csv("points_needed.csv", &needed)?,
            text("data_efficiency.md", markdown(&needed, &rows)),
        ],
        &caption(&rows),
        |width| draw(&rows, width),
    )
}

/// Real points behind a cell: those of its process or those of its network.
fn points(row: &ControllerRow) -> u64 {
    row.cell.gp_points.max(row.cell.real_points)
}

/// The cells of one training, mode and policy, by the number of points.
fn curve<'a>(rows: &[&'a ControllerRow], mode: &str, policy: &str) -> Vec<&'a ControllerRow> {
    let mut cells: Vec<&ControllerRow> = rows
        .iter()
        .copied()
        .filter(|row| row.cell.mode == mode && row.cell.policy == policy)
        .collect();
    cells.sort_by_key(|row| points(row));
    cells
}

/// For each curve and wanted error the fewest points from which on the mean error at the end stays
/// within it.
fn points_needed(rows: &[ControllerRow]) -> Vec<PointsNeededRow> {
    let mut needed = Vec::new();
    for training in trainings(rows.iter().map(|row| row.training.as_str())) {
        let of_training: Vec<&ControllerRow> =
            rows.iter().filter(|row| row.training == training).collect();
        for mode in modes_in_order(of_training.iter().map(|row| row.cell.mode.as_str())) {
            for policy in policies_in_order(
                of_training
                    .iter()
                    .filter(|row| row.cell.mode == mode)
                    .map(|row| row.cell.policy.as_str()),
            ) {
                let curve: Vec<(u64, f64)> = curve(&of_training, mode, policy)
                    .iter()
                    .map(|row| (points(row), row.error_end_m))
                    .collect();
                needed.extend(WANTED_M.iter().map(|&wanted_m| PointsNeededRow {
                    training: training.to_owned(),
                    policy: policy.to_owned(),
                    mode: mode.to_owned(),
                    wanted_m,
                    points: fewest(&curve, wanted_m),
                    most_points: curve.last().map_or(0, |(points, _)| *points),
                }));
            }
        }
    }
    needed
}

/// Of points and error, points ascending; not a number where the error is larger with the most
/// points.
fn fewest(curve: &[(u64, f64)], wanted_m: f64) -> f64 {
    let within = curve.iter().rev().take_while(|(_, error_m)| *error_m <= wanted_m);
    within.last().map_or(f64::NAN, |(points, _)| *points as f64)
}

fn markdown(needed: &[PointsNeededRow], rows: &[ControllerRow]) -> String {
    let mut header: Vec<String> = ["policy", "training", "mode"].map(str::to_owned).to_vec();
    header.extend(WANTED_M.iter().map(|wanted_m| format!("points for {} mm", 1e3 * wanted_m)));
    header.push("error, points: mean (95 % interval)".to_owned());
    let line = |of: &[PointsNeededRow]| {
        let first = &of[0];
        let count = |row: &PointsNeededRow| match row.points.is_finite() {
            true => row.points.to_string(),
            false if row.most_points == 0 => "–".to_owned(),
            false => format!("> {}", row.most_points),
        };
        let of_training: Vec<&ControllerRow> =
            rows.iter().filter(|row| row.training == first.training).collect();
        let curve = curve(&of_training, &first.mode, &first.policy);
        let cell = |row: &&ControllerRow| {
            format!(
                "{}: {} ({}–{})",
                points(row),
                mm(row.error_end_m),
                mm(row.low_95_m),
                mm(row.high_95_m)
            )
        };
        let mut cells = vec![
            policy_markdown(&first.policy).to_owned(),
            first.training.clone(),
            first.mode.clone(),
        ];
        cells.extend(of.iter().map(count));
        cells.push(curve.iter().map(cell).collect::<Vec<_>>().join(" · "));
        cells
    };
    let head = "Number of real points from which the mean error of the true tip at the end of a \
                trial stays within 5, 3 and 2 mm; 0: without real points. Errors in mm, by number \
                of points.\n\n";
    let rows = needed.chunks(WANTED_M.len()).map(line).collect();
    head.to_owned() + &MarkdownTable { header, rows }.markdown()
}

fn caption(rows: &[ControllerRow]) -> String {
    let training = last_training(rows.iter().map(|row| row.training.as_str()));
    let trials = rows.iter().map(|row| row.trials).max().unwrap_or(0);
    let seeds = rows.iter().map(|row| row.seeds).max().unwrap_or(0);
    format!(
        "Error of the true tip at the end of a trial and after 2 s, in mm, against the number of \
         real points that each policy uses, both on logarithmic axes; level lines from 0 are policies \
         without real points; {}. Marks are means over {trials} trials in {seeds} repetitions.",
        training_label(training)
    )
}

/// An error of a row, metres.
type ErrorOf = fn(&ControllerRow) -> f64;

/// The panels of the last kind of training, where networks are at their best: at the end above,
/// after 2 s below.
fn draw(rows: &[ControllerRow], width: f64) -> Canvas {
    let training = last_training(rows.iter().map(|row| row.training.as_str()));
    let rows: Vec<&ControllerRow> = rows.iter().filter(|row| row.training == training).collect();
    let modes = modes_in_order(rows.iter().map(|row| row.cell.mode.as_str()));
    let policies = policies_in_order(rows.iter().map(|row| row.cell.policy.as_str()));
    let mut sizes = distinct(rows.iter().map(|row| points(row)));
    sizes.sort_unstable();
    let names = ends_width(policies.iter().map(|policy| policy_label(policy)));
    let per_line = if width < NARROW { 1 } else { modes.len().max(1) };
    let (high, pitch) = (150.0, 206.0);
    let wide = (width - (LEFT_MARGIN + names) * per_line as f64) / per_line as f64;
    let mut canvas = Canvas::new(width, TALL);
    let moments: [(&str, ErrorOf); 2] =
        [("at the end", |row| row.error_end_m), ("after 2 s", |row| row.error_2s_m)];
    let mut place = 0;
    for (when, error_m) in moments {
        let all = rows.iter().map(|row| 1e3 * error_m(row));
        let y = Axis::log("error (mm)", all, 2.0 * high);
        for mode in &modes {
            let (line, column) = (place / per_line, place % per_line);
            let left = LEFT_MARGIN + (LEFT_MARGIN + names + wide) * column as f64;
            let panel = canvas.panel(Panel {
                corner: [left, 26.0 + pitch * line as f64],
                size: [wide, high],
                x: Axis::sizes("real points", &sizes),
                y: y.clone(),
                title: capitalised(&format!("{}, {when}", mode_title(mode))),
            });
            let curves = policies.iter().map(|policy| (*policy, curve(&rows, mode, policy)));
            lines(&mut canvas, &panel, curves, error_m);
            place += 1;
        }
    }
    canvas.height = (26.0 + pitch * place.div_ceil(per_line) as f64 - 10.0).round();
    canvas
}

/// The lines of one panel, each with its name at its end.
fn lines<'a>(
    canvas: &mut Canvas,
    panel: &Panel,
    curves: impl Iterator<Item = (&'a str, Vec<&'a ControllerRow>)>,
    error_m: fn(&ControllerRow) -> f64,
) {
    let mut ends = Vec::new();
    for (policy, cells) in curves {
        let tick = |size: u64| {
            let label = thousands(size);
            panel.x.ticks.iter().find(|(_, name)| *name == label).map_or(f64::NAN, |tick| tick.0)
        };
        let point =
            |row: &&ControllerRow| [tick(points(row)), (1e3 * error_m(row)).log10(), f64::NAN];
        let line: Vec<[f64; 3]> =
            cells.iter().map(point).filter(|point| point[1].is_finite()).collect();
        let look = policy_look(policy);
        let Some(&[x, y, _]) = line.last() else { continue };
        // The error of a policy without real points is the same for any number of them.
        let is_level = cells.iter().all(|row| points(row) == 0);
        if is_level {
            panel.line(canvas, &[[x, y], [panel.x.high, y]], look.colour, look.dash, HAIR);
        }
        panel.series(canvas, &line, look);
        let at = panel.at(if is_level { panel.x.high } else { x }, y);
        ends.push(LineEnd { at, name: policy_label(policy).to_owned(), colour: look.colour });
    }
    name_ends(canvas, panel, ends);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_that_rises_again_needs_more_points() {
        let curve = [(5, 0.004), (10, 0.006), (20, 0.0045), (50, 0.0025)];
        assert_eq!(fewest(&curve, 0.005), 20.0);
        assert_eq!(fewest(&curve, 0.003), 50.0);
        assert!(fewest(&curve, 0.002).is_nan());
    }
}
