//! The benchmark's shares with their intervals beside what was to be reached.

use super::measures::{SummaryRow, is_ratio};
use super::table::{interval, plain};
use crate::report::discovery::format::fitted;
use crate::report::drawing::{
    Axis, Canvas, CanvasPoint, LegendEntry, Panel, Text, TextAlign, legend,
};
use crate::report::order::distinct;
use crate::report::style::{GREEN, GREY, INK, LOOKS, Look, MARKER, PAGE_WIDTH, SMALL};

const LEFT_MARGIN: f64 = 262.0;
const RIGHT_MARGIN: f64 = 150.0;
const TOP_MARGIN: f64 = 52.0;

/// Draws every share: all cases, or each number of samples where there are several.
pub(crate) fn draw(rows: &[SummaryRow]) -> Canvas {
    let rows: Vec<&SummaryRow> = rows.iter().filter(|row| !is_ratio(&row.measure)).collect();
    let parts = parts(&rows);
    let measures = distinct(rows.iter().map(|row| row.measure.as_str()));
    let pitch = 9.0 + 11.0 * parts.len() as f64;
    let high = pitch * measures.len() as f64;
    let mut canvas = Canvas::new(PAGE_WIDTH, (TOP_MARGIN + high + 46.0).ceil());
    let keys: Vec<(LegendEntry, &str)> =
        parts.iter().zip(LOOKS).map(|(part, look)| (marker(look), *part)).collect();
    legend(&mut canvas, [LEFT_MARGIN, 18.0], 520.0, &keys);
    let goal = [540.0, 18.0];
    canvas.rectangle([goal[0], goal[1] - 9.0], [goal[0] + 22.0, goal[1] + 2.0], GREEN, 0.22);
    canvas.line(&[[goal[0], goal[1] - 9.0], [goal[0], goal[1] + 2.0]], 1.4, GREEN, &[]);
    canvas.text(Text::new("to be reached", [goal[0] + 27.0, goal[1]], SMALL, TextAlign::Left));
    canvas.text(
        Text::new(
            "[95 % interval]",
            [PAGE_WIDTH - 10.0, TOP_MARGIN - 8.0],
            SMALL,
            TextAlign::Right,
        )
        .colour(GREY),
    );
    let panel = canvas.panel(Panel {
        corner: [LEFT_MARGIN, TOP_MARGIN],
        size: [PAGE_WIDTH - LEFT_MARGIN - RIGHT_MARGIN, high],
        x: Axis::exact("share (%)", 0.0, 100.0, 5),
        y: Axis::bare_to(1.0),
        title: String::new(),
    });
    for (index, measure) in measures.iter().enumerate() {
        let y = TOP_MARGIN + pitch * index as f64;
        let name = fitted(measure, SMALL, LEFT_MARGIN - 24.0);
        canvas.text(Text::new(
            name,
            [LEFT_MARGIN - 8.0, y + 0.5 * pitch + 3.5],
            SMALL,
            TextAlign::Right,
        ));
        let of = |part: &&str| {
            rows.iter().find(|row| row.measure == *measure && row.part == **part).copied()
        };
        if let Some(row) = rows.iter().find(|row| row.measure == *measure) {
            reach(&mut canvas, &panel, row, [y + 1.5, y + pitch - 1.5]);
        }
        for (turn, (part, look)) in parts.iter().zip(LOOKS).enumerate() {
            if let Some(row) = of(part) {
                mark(&mut canvas, &panel, row, look, y + 10.0 + 11.0 * turn as f64);
            }
        }
    }
    canvas
}

fn marker(look: Look) -> LegendEntry {
    LegendEntry::Marker(look.marker, look.colour, false)
}

/// Numbers of samples where there are several, else all cases; no more than there are looks.
fn parts<'a>(rows: &[&'a SummaryRow]) -> Vec<&'a str> {
    let all = distinct(rows.iter().map(|row| row.part.as_str()));
    let samples: Vec<&str> =
        all.iter().copied().filter(|part| part.ends_with(" samples")).collect();
    let parts = if samples.is_empty() { all } else { samples };
    parts.into_iter().take(4).collect()
}

/// The range to be reached, its inner edge marked.
fn reach(canvas: &mut Canvas, panel: &Panel, row: &SummaryRow, [top, bottom]: [f64; 2]) {
    if !(row.goal_low.is_finite() && row.goal_high.is_finite()) {
        return;
    }
    let x = |share: f64| panel.at(100.0 * share, 0.0)[0];
    canvas.rectangle([x(row.goal_low) - 0.8, top], [x(row.goal_high) + 0.8, bottom], GREEN, 0.22);
    let always = row.goal_low == row.goal_high;
    for edge in [row.goal_low, row.goal_high]
        .into_iter()
        .filter(|edge| *edge > 0.0 && (*edge < 1.0 || always))
    {
        canvas.line(&[[x(edge), top], [x(edge), bottom]], 1.4, GREEN, &[]);
    }
}

/// A share with its interval, and both in numbers.
fn mark(canvas: &mut Canvas, panel: &Panel, row: &SummaryRow, look: Look, y: f64) {
    let place =
        |share: f64| -> CanvasPoint { [panel.at((100.0 * share).clamp(0.0, 100.0), 0.0)[0], y] };
    if row.low_95.is_finite() && row.high_95.is_finite() {
        canvas.line(&[place(row.low_95), place(row.high_95)], 1.6, look.colour, &[]);
    }
    if row.value.is_finite() {
        canvas.marker(place(row.value), look.marker, 0.85 * MARKER, look.colour, false);
    }
    let label = format!("{}{}", plain(row), interval(row));
    canvas.text(
        Text::new(label, [PAGE_WIDTH - 10.0, y + 3.5], 0.92 * SMALL, TextAlign::Right).colour(INK),
    );
}
