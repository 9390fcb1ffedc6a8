//! The benchmark's shares with their intervals beside what was to be reached.

use super::measures::{SummaryRow, is_ratio};
use super::table::{interval, plain};
use crate::report::drawing::{
    Axis, Canvas, Dot, DotChart, DotPanel, DotRow, LegendEntry, Text, TextAlign, legend,
};
use crate::report::order::distinct;
use crate::report::style::{GREEN, LOOKS, Look, SMALL, TALL};

/// What the picture shows.
pub(crate) fn caption(rows: &[SummaryRow]) -> String {
    let cases = rows.iter().map(|row| row.cases).max().unwrap_or(0);
    format!(
        "Results of the blind benchmark of discovery over up to {cases} cases: share of the cases \
         of each line, in %, with Wilson’s 95 % interval (for medians, order statistics). Green: \
         target range."
    )
}

/// Draws every share: all cases, or each number of samples where there are several.
pub(crate) fn draw(rows: &[SummaryRow], width: f64) -> Canvas {
    let rows: Vec<&SummaryRow> = rows.iter().filter(|row| !is_ratio(&row.measure)).collect();
    let parts = parts(&rows);
    let measures = distinct(rows.iter().map(|row| row.measure.as_str()));
    let mut canvas = Canvas::new(width, TALL);
    let keys: Vec<(LegendEntry, &str)> =
        parts.iter().zip(LOOKS).map(|(part, look)| (marker(look), *part)).collect();
    let base = legend(&mut canvas, [10.0, 16.0], width - 130.0, &keys);
    let goal = [width - 112.0, 16.0];
    canvas.rectangle([goal[0], goal[1] - 9.0], [goal[0] + 22.0, goal[1] + 2.0], GREEN, 0.25);
    canvas.text(Text::new("to be reached", [goal[0] + 27.0, goal[1]], SMALL, TextAlign::Left));
    let cells = measures.iter().enumerate().flat_map(|(row, measure)| {
        let of_measure = rows.iter().copied().filter(move |row| row.measure == *measure);
        of_measure.map(move |of_measure| (row, of_measure))
    });
    let dots = cells.clone().filter_map(|(row, share)| {
        let lane = parts.iter().position(|part| *part == share.part)?;
        Some(dot(row, lane, share))
    });
    let has_goal = |share: &SummaryRow| share.goal_low.is_finite() && share.goal_high.is_finite();
    let goals = cells
        .clone()
        .filter(|(_, share)| has_goal(share))
        .map(|(row, share)| (row, [share.goal_low, share.goal_high].map(|share| 100.0 * share)));
    let mut goals: Vec<(usize, [f64; 2])> = goals.collect();
    goals.dedup_by_key(|goal| goal.0);
    let x = Axis::exact("share (%)", 0.0, 100.0, 5);
    let lanes = parts.len();
    let chart = DotChart {
        rows: measures.iter().map(|name| DotRow::Named((*name).to_owned(), lanes)).collect(),
        lane_height: 13.0,
        min_panel: 80.0,
        aside: 108.0,
        panels: vec![DotPanel { goals, ..DotPanel::new("", x, dots.collect()) }],
    };
    canvas.height = chart.draw(&mut canvas, base + 16.0).round();
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

/// A share with its interval, and both in numbers.
fn dot(row: usize, lane: usize, share: &SummaryRow) -> Dot {
    let look = LOOKS[lane.min(LOOKS.len() - 1)];
    let percent = |share: f64| (100.0 * share).clamp(0.0, 100.0);
    Dot {
        thin: Some([share.low_95, share.high_95].map(percent)),
        words: format!("{}{}", plain(share), interval(share)),
        ..Dot::new(row, lane, percent(share.value), look.marker, look.colour)
    }
}
