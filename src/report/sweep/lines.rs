//! One swept field: a panel for each kind of training and mode, a line for each policy.

use super::field::SweptAxis;
use super::{SweepEntry, series_label, sized, training_heading};
use crate::report::drawing::{Axis, Canvas, LegendEntry, Panel, Text, TextAlign, legend};
use crate::report::order::{distinct, trainings};
use crate::report::style::{
    GREY, LOOKS, Look, PAGE_WIDTH, SMALL, TALL, TEXT, heading, mode_title, policy_look,
};

const LEFT_MARGIN: f64 = 58.0;
const PANEL_GAP: f64 = 52.0;
/// Height of a panel, and distance from one row of panels to the next.
const PANEL_HEIGHT: f64 = 165.0;
const PANEL_PITCH: f64 = 226.0;
/// Lines with more points have no markers and bars, which would cover each other.
const MAX_MARKED_POINTS: usize = 60;

pub(super) fn draw(entries: &[&SweepEntry], field: &SweptAxis, measure: &str) -> Canvas {
    let kinds = trainings(entries.iter().map(|entry| entry.row.training.as_str()));
    let modes = distinct(entries.iter().map(|entry| entry.row.cell.mode.as_str()));
    let sized = sized(entries);
    let label = |entry: &SweepEntry| series_label(entry.row, sized);
    let series = distinct(entries.iter().map(|entry| label(entry)));
    let looks: Vec<Look> =
        series.iter().enumerate().map(|(index, name)| look(entries, sized, index, name)).collect();
    // Bands of more than two lines would overlap: bars side by side instead.
    let banded = series.len() <= 2 && field.is_number();
    let key = |look| if banded { LegendEntry::Series(look) } else { LegendEntry::Plain(look) };
    let mut canvas = Canvas::new(PAGE_WIDTH, TALL);
    let keys: Vec<(LegendEntry, &str)> =
        looks.iter().map(|look| key(*look)).zip(series.iter().map(String::as_str)).collect();
    let below = legend(&mut canvas, [LEFT_MARGIN, 16.0], PAGE_WIDTH - 10.0, &keys);
    let kind = if banded { "band" } else { "bars" };
    let note = format!("{kind}: ± 1 standard deviation over repetitions");
    canvas.text(Text::new(note, [LEFT_MARGIN, below + 17.0], SMALL, TextAlign::Left).colour(GREY));
    let wide = (PAGE_WIDTH - LEFT_MARGIN - 14.0 - PANEL_GAP * (kinds.len() - 1) as f64)
        / kinds.len() as f64;
    let headed = kinds.iter().any(|training| !training_heading(training).is_empty());
    let top = below + if headed { 60.0 } else { 42.0 };
    for (column, training) in kinds.iter().enumerate() {
        let middle = LEFT_MARGIN + column as f64 * (wide + PANEL_GAP) + wide / 2.0;
        let title =
            if training_heading(training).is_empty() { String::new() } else { heading(training) };
        canvas.text(Text::new(title, [middle, below + 37.0], TEXT, TextAlign::Centre).bold());
    }
    for (line, mode) in modes.iter().enumerate() {
        for (column, training) in kinds.iter().enumerate() {
            let of_panel = entries
                .iter()
                .filter(|entry| entry.row.cell.mode == *mode && entry.row.training == *training);
            let of_panel: Vec<&&SweepEntry> = of_panel.collect();
            let panel = canvas.panel(Panel {
                corner: [
                    LEFT_MARGIN + column as f64 * (wide + PANEL_GAP),
                    top + PANEL_PITCH * line as f64,
                ],
                size: [wide, PANEL_HEIGHT],
                x: field.axis(wide),
                y: errors(&of_panel, if column == 0 { measure } else { "" }),
                title: mode_title(mode),
            });
            let lines = series.iter().zip(&looks).enumerate().map(|(index, (name, look))| {
                let aside =
                    if banded { 0.0 } else { index as f64 - (series.len() - 1) as f64 / 2.0 };
                (
                    points(
                        &of_panel,
                        field,
                        aside * 0.012 * (panel.x.high - panel.x.low),
                        |entry| label(entry) == *name,
                    ),
                    *look,
                )
            });
            curves(&mut canvas, &panel, &lines.collect::<Vec<_>>(), banded, field.is_number());
        }
    }
    canvas.height = (top + PANEL_PITCH * modes.len() as f64 - 12.0).round();
    canvas
}

/// The style of a policy, as in every figure; several sizes of a policy take the styles in turn.
fn look(entries: &[&SweepEntry], sized: bool, index: usize, name: &str) -> Look {
    let policy = entries
        .iter()
        .find(|entry| series_label(entry.row, sized) == name)
        .map(|entry| &entry.row.cell.policy);
    match policy {
        Some(policy) if !sized && !policy.is_empty() => policy_look(policy),
        _ => LOOKS[index % LOOKS.len()],
    }
}

/// The axis of errors, millimetres, including one standard deviation.
fn errors(entries: &[&&SweepEntry], measure: &str) -> Axis {
    let ends = entries.iter().flat_map(|entry| {
        let spread_m =
            if entry.row.sd_over_seeds_m.is_finite() { entry.row.sd_over_seeds_m } else { 0.0 };
        [entry.row.mean_m - spread_m, entry.row.mean_m + spread_m].map(|end_m| 1e3 * end_m)
    });
    Axis::covering(measure, ends, 5)
}

/// Position, mean and standard deviation of the points of one line, in the order of the axis.
fn points(
    entries: &[&&SweepEntry],
    field: &SweptAxis,
    aside: f64,
    in_line: impl Fn(&SweepEntry) -> bool,
) -> Vec<[f64; 3]> {
    let line_entries =
        entries.iter().filter(|entry| in_line(entry) && entry.row.mean_m.is_finite());
    let point = |entry: &&&SweepEntry| {
        let place = entry.at.first().map_or(f64::NAN, |value| field.place(value));
        [place + aside, 1e3 * entry.row.mean_m, 1e3 * entry.row.sd_over_seeds_m]
    };
    let mut points: Vec<[f64; 3]> = line_entries.map(point).collect();
    points.sort_by(|one, other| one[0].total_cmp(&other[0]));
    points
}

/// Draws bands, then bars, then lines on top. Names are not joined by lines.
fn curves(
    canvas: &mut Canvas,
    panel: &Panel,
    lines: &[(Vec<[f64; 3]>, Look)],
    banded: bool,
    joined: bool,
) {
    for (points, look) in lines {
        if banded {
            panel.band(canvas, points, *look);
        }
        if !banded && points.len() <= MAX_MARKED_POINTS {
            for [x, mean, sd] in points.iter().filter(|point| point[2].is_finite()) {
                let ends = [mean - sd, mean + sd].map(|end| end.clamp(panel.y.low, panel.y.high));
                panel.interval(canvas, *x, ends, look.colour);
            }
        }
    }
    for (points, look) in lines {
        if points.len() > MAX_MARKED_POINTS {
            let line: Vec<[f64; 2]> = points.iter().map(|[x, mean, _]| [*x, *mean]).collect();
            panel.line(canvas, &line, look.colour, look.dash, 1.0);
        } else if joined {
            panel.series(canvas, points, *look);
        } else {
            points.iter().for_each(|point| panel.series(canvas, &[*point], *look));
        }
    }
}
