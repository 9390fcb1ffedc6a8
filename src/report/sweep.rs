//! The default figure of an experiment that sweeps one number, or two (the second as series).

use super::axes::{Axis, Panel, range};
use super::canvas::Canvas;
use super::legend::{Key, legend};
use super::style::{LOOKS, PAGE_WIDTH};
use super::{Artifact, Figure, Published, ReportError, pictures};
use crate::data::rows::SweepRow;

/// Registry entry.
pub(super) const FIGURE: Figure = Figure { name: "sweep", about: "A measured quantity against a swept one", render };

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    let rows = &published.sweep;
    let Some(first) = rows.first() else {
        return Err(ReportError::NoRows { figure: FIGURE.name, needs: "sweep.csv" });
    };
    if let Some(other) = rows.iter().find(|row| row.x_label != first.x_label || row.y_label != first.y_label) {
        let found = format!("`{}` and `{}`", first.x_label, other.x_label);
        return Err(ReportError::Mixed { figure: FIGURE.name, found, expected: "swept quantity and measure" });
    }
    Ok(pictures(FIGURE.name, FIGURE.name, &draw(rows))?.to_vec())
}

fn draw(rows: &[SweepRow]) -> Canvas {
    let mut names: Vec<&str> = Vec::new();
    for row in rows {
        if !names.contains(&row.series.as_str()) {
            names.push(&row.series);
        }
    }
    let mut canvas = Canvas::new(PAGE_WIDTH / 1.5, 300.0);
    // Bands of more than two series would only darken each other: bars beside each other instead.
    let banded = names.len() <= 2;
    let key = |look| if banded { Key::Series(look) } else { Key::Plain(look) };
    let keys: Vec<(Key, &str)> =
        names.iter().enumerate().map(|(index, name)| (key(LOOKS[index % LOOKS.len()]), *name)).collect();
    let below = legend(&mut canvas, [62.0, 16.0], PAGE_WIDTH / 1.5, &keys);
    let spread = |row: &SweepRow| if row.sd.is_finite() { row.sd } else { 0.0 };
    let ends = rows.iter().flat_map(|row| [row.mean - spread(row), row.mean + spread(row)]);
    let (low, high) = range(rows.iter().map(|row| row.x));
    let room = 0.05 * (high - low);
    let top = below + 18.0;
    let panel = Panel {
        corner: [62.0, top],
        size: [PAGE_WIDTH / 1.5 - 76.0, 254.0 - top],
        x: Axis::exact(&rows[0].x_label, low - room, high + room, 6),
        y: Axis::covering(&rows[0].y_label, ends, 5),
        title: String::new(),
    };
    panel.draw(&mut canvas);
    let points = |index: usize| {
        let aside = 0.014 * (high - low) * (index as f64 - (names.len() - 1) as f64 / 2.0);
        let x = |row: &SweepRow| if banded { row.x } else { row.x + aside };
        let rows = rows.iter().filter(|row| row.series == names[index]);
        let mut points: Vec<[f64; 3]> = rows.map(|row| [x(row), row.mean, row.sd]).collect();
        points.sort_by(|one, other| one[0].total_cmp(&other[0]));
        points
    };
    for index in 0..names.len() {
        let look = LOOKS[index % LOOKS.len()];
        if banded {
            panel.band(&mut canvas, &points(index), look);
        }
        for [x, mean, sd] in points(index).into_iter().filter(|[_, _, sd]| sd.is_finite() && !banded) {
            panel.interval(&mut canvas, x, [mean - sd, mean + sd], look.colour);
        }
    }
    for index in 0..names.len() {
        panel.series(&mut canvas, &points(index), LOOKS[index % LOOKS.len()]);
    }
    canvas
}
