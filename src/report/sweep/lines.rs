//! One swept field: of numbers a panel for each mode and kind of training with a line for each
//! policy, of names a chart with a row for each policy.

use super::field::SweptAxis;
use super::{SweepEntry, series_label, sized};
use crate::report::cells::modes_in_order;
use crate::report::drawing::{
    Axis, Canvas, Dot, DotChart, DotPanel, DotRow, LegendEntry, LineEnd, MIN_PANEL, Panel,
    ends_width, legend, name_ends,
};
use crate::report::order::{distinct, trainings};
use crate::report::style::{
    LEFT_MARGIN, LOOKS, Look, NARROW, TALL, capitalised, mode_title, policy_look, training_short,
};

/// Height of a panel, and distance from one row of panels to the next.
const PANEL_HEIGHT: f64 = 150.0;
const PANEL_PITCH: f64 = 212.0;
/// Lines with more points have no markers and bars, which would cover each other.
const MAX_MARKED_POINTS: usize = 60;

pub(super) fn draw(
    entries: &[&SweepEntry],
    field: &SweptAxis,
    measure: &str,
    width: f64,
) -> Canvas {
    let panels = panels(entries);
    if field.is_number() {
        curves(entries, &panels, field, measure, width)
    } else {
        chart(entries, &panels, field, width)
    }
}

/// What one panel shows.
struct SweepPanel<'a> {
    title: String,
    entries: Vec<&'a SweepEntry<'a>>,
}

/// The panels: modes, and kinds of training side by side.
fn panels<'a>(entries: &[&'a SweepEntry<'a>]) -> Vec<SweepPanel<'a>> {
    let kinds = trainings(entries.iter().map(|entry| entry.row.training.as_str()));
    let mut panels = Vec::new();
    for mode in modes_in_order(entries.iter().map(|entry| entry.row.cell.mode.as_str())) {
        for kind in &kinds {
            let of_panel = entries
                .iter()
                .copied()
                .filter(|entry| entry.row.cell.mode == mode && entry.row.training == *kind);
            let of_panel: Vec<&SweepEntry> = of_panel.collect();
            let title = match (kinds.len(), mode_title(mode)) {
                (1, mode) => mode,
                (_, mode) => format!("{mode}, {}", training_short(kind)),
            };
            if !of_panel.is_empty() {
                panels.push(SweepPanel { title: capitalised(&title), entries: of_panel });
            }
        }
    }
    panels
}

/// The lines of a figure with their looks, by name.
fn series(entries: &[&SweepEntry]) -> Vec<(String, Look)> {
    let sized = sized(entries);
    let names = distinct(entries.iter().map(|entry| series_label(entry.row, sized)));
    let look = |(index, name): (usize, String)| {
        let of_name = entries.iter().find(|entry| series_label(entry.row, sized) == name);
        let policy = of_name.map_or("", |entry| &entry.row.cell.policy);
        let look = if sized || policy.is_empty() {
            LOOKS[index % LOOKS.len()]
        } else {
            policy_look(policy)
        };
        (name, look)
    };
    names.into_iter().enumerate().map(look).collect()
}

/// Lines with their names at their ends.
fn curves(
    entries: &[&SweepEntry],
    panels: &[SweepPanel],
    field: &SweptAxis,
    measure: &str,
    width: f64,
) -> Canvas {
    let (series, sized) = (series(entries), sized(entries));
    // Bands of more than two lines would overlap: bars side by side instead.
    let banded = series.len() <= 2;
    let names = ends_width(series.iter().map(|(name, _)| name.as_str()));
    let per_line = if width < NARROW || panels.len() == 1 { 1 } else { 2 };
    let wide = width / per_line as f64 - LEFT_MARGIN - names;
    let mut canvas = Canvas::new(width, TALL);
    for (place, shown) in panels.iter().enumerate() {
        let (line, column) = (place / per_line, place % per_line);
        let left = LEFT_MARGIN + (LEFT_MARGIN + names + wide) * column as f64;
        let panel = canvas.panel(Panel {
            corner: [left, 26.0 + PANEL_PITCH * line as f64],
            size: [wide, PANEL_HEIGHT],
            x: field.axis(wide),
            y: errors(&shown.entries, short(measure)),
            title: shown.title.clone(),
        });
        let lines = series.iter().enumerate().map(|(index, (name, look))| {
            let aside = if banded { 0.0 } else { index as f64 - (series.len() - 1) as f64 / 2.0 };
            let aside = aside * 0.012 * (panel.x.high - panel.x.low);
            let in_line = |entry: &SweepEntry| series_label(entry.row, sized) == *name;
            (points(&shown.entries, field, aside, in_line), name.as_str(), *look)
        });
        paint(&mut canvas, &panel, &lines.collect::<Vec<_>>(), banded);
    }
    let lines = panels.len().div_ceil(per_line) as f64;
    canvas.height = (26.0 + PANEL_PITCH * lines - 14.0).round();
    canvas
}

/// The measure as the label of an axis: the caption says it in full.
fn short(measure: &str) -> &str {
    if measure.starts_with("cross") { "cross-validated (mm)" } else { "error (mm)" }
}

/// The axis of errors, millimetres, including one standard deviation.
fn errors(entries: &[&SweepEntry], measure: &str) -> Axis {
    let ends = entries.iter().flat_map(|entry| {
        let spread_m =
            if entry.row.sd_over_seeds_m.is_finite() { entry.row.sd_over_seeds_m } else { 0.0 };
        [entry.row.mean_m, entry.row.mean_m + spread_m].map(|end_m| 1e3 * end_m)
    });
    Axis::from_zero(measure, ends, 4)
}

/// Position, mean and standard deviation of the points of one line, in the order of the axis.
fn points(
    entries: &[&SweepEntry],
    field: &SweptAxis,
    aside: f64,
    in_line: impl Fn(&SweepEntry) -> bool,
) -> Vec<[f64; 3]> {
    let line_entries =
        entries.iter().filter(|entry| in_line(entry) && entry.row.mean_m.is_finite());
    let point = |entry: &&SweepEntry| {
        let place = entry.at.first().map_or(f64::NAN, |value| field.place(value));
        [place + aside, 1e3 * entry.row.mean_m, 1e3 * entry.row.sd_over_seeds_m]
    };
    let mut points: Vec<[f64; 3]> = line_entries.map(point).collect();
    points.sort_by(|one, other| one[0].total_cmp(&other[0]));
    points
}

/// Draws bands, then bars, then lines on top, and their names.
fn paint(canvas: &mut Canvas, panel: &Panel, lines: &[(Vec<[f64; 3]>, &str, Look)], banded: bool) {
    for (points, _, look) in lines {
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
    let mut ends = Vec::new();
    for (points, name, look) in lines {
        if points.len() > MAX_MARKED_POINTS {
            let line: Vec<[f64; 2]> = points.iter().map(|[x, mean, _]| [*x, *mean]).collect();
            panel.line(canvas, &line, look.colour, look.dash, 1.0);
        } else {
            panel.series(canvas, points, *look);
        }
        if let Some([x, y, _]) = points.last() {
            let at = panel.at(*x, *y);
            ends.push(LineEnd { at, name: (*name).to_owned(), colour: look.colour });
        }
    }
    // One line alone needs no name.
    if lines.len() > 1 {
        name_ends(canvas, panel, ends);
    }
}

/// A row for each policy with a mark for each value of the field; of many values a row for each
/// value and a mark for each policy.
fn chart(entries: &[&SweepEntry], panels: &[SweepPanel], field: &SweptAxis, width: f64) -> Canvas {
    let (series, sized) = (series(entries), sized(entries));
    let values: Vec<String> = field.values.iter().map(|value| field.shown(value, 160.0)).collect();
    let by_policy = values.len() <= LOOKS.len();
    let names: Vec<String> = series.iter().map(|(name, _)| name.clone()).collect();
    let looks: Vec<Look> =
        if by_policy { LOOKS.to_vec() } else { series.iter().map(|(_, look)| *look).collect() };
    let (rows, marks) = if by_policy { (names, values) } else { (values, names) };
    let ends = entries.iter().map(|entry| 1e3 * (entry.row.mean_m + entry.row.sd_over_seeds_m));
    let means = entries.iter().map(|entry| 1e3 * entry.row.mean_m);
    let x = Axis::from_zero("error (mm)", ends.chain(means), 3);
    let panel = |shown: &SweepPanel| {
        let dots = shown.entries.iter().filter_map(|entry| {
            let value = field.index(entry.at.first())?;
            let label = series_label(entry.row, sized);
            let line = series.iter().position(|(name, _)| *name == label)?;
            let (row, lane) = if by_policy { (line, value) } else { (value, line) };
            let look = looks[lane % looks.len()];
            let ends = [-1.0, 1.0].map(|sign| entry.row.mean_m + sign * entry.row.sd_over_seeds_m);
            Some(Dot {
                thin: Some(ends.map(|end_m| 1e3 * end_m)),
                ..Dot::new(row, lane, 1e3 * entry.row.mean_m, look.marker, look.colour)
            })
        });
        DotPanel::new(&shown.title, x.clone(), dots.collect())
    };
    let mut canvas = Canvas::new(width, TALL);
    let keys: Vec<(LegendEntry, &str)> = looks
        .iter()
        .zip(&marks)
        .map(|(look, name)| (LegendEntry::Marker(look.marker, look.colour, false), name.as_str()))
        .collect();
    let base = legend(&mut canvas, [10.0, 16.0], width - 8.0, &keys);
    let chart = DotChart {
        rows: rows.into_iter().map(|name| DotRow::Named(name, marks.len())).collect(),
        lane_height: 9.5,
        min_panel: MIN_PANEL,
        aside: 0.0,
        panels: panels.iter().map(panel).collect(),
    };
    canvas.height = chart.draw(&mut canvas, base + 30.0).round();
    canvas
}
