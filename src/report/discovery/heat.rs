//! Where they disagree, as a table in colours: a row for each place, and for each axis the residual
//! over the noise floor without and with the effects.

use super::super::style::{GREY, HAIR, INK, SMALL, TEXT, capitalised};
use super::DiscoveryReport;
use super::format::{fitted, ratio_text};
use super::scale::{SIGNIFICANCE_LEVEL, cell, marked};
use crate::data::findings::PlaceRow;
use crate::report::drawing::{Canvas, CanvasPoint, Text, TextAlign};

const ROW_HEIGHT: f64 = 17.0;
/// Axes in the order of their columns, and their headings.
const AXES: [(&str, &str); 4] = [("x", "x"), ("y", "y"), ("z", "z"), ("all", "distance")];

/// Where the columns stand.
struct Columns<'a> {
    /// Axes that have rows.
    axes: Vec<&'a (&'static str, &'static str)>,
    /// Left end of the first column.
    first: f64,
    /// From axis to axis.
    pitch: f64,
    /// Width of one cell.
    wide: f64,
    /// Whether the effects changed anything.
    has_after: bool,
    /// Whether places are marked before and after.
    marked: [bool; 2],
}

/// Draws the table from `top` down and returns where it ends.
pub(super) fn draw(canvas: &mut Canvas, report: &DiscoveryReport, top: f64) -> f64 {
    let (rows, has_after) = (report.places, report.changed());
    let (left, right) = (12.0, canvas.width - 12.0);
    let axes: Vec<_> =
        AXES.iter().filter(|(axis, _)| rows.iter().any(|row| row.axis == *axis)).collect();
    let first = left + if canvas.width > 500.0 { 200.0 } else { 112.0 };
    let pitch = (right - first + 8.0) / axes.len().max(1) as f64;
    let wide = (pitch - 8.0) / if has_after { 2.0 } else { 1.0 };
    let columns = Columns { axes, first, pitch, wide, has_after, marked: marked(report.findings) };
    let mut y = headings(canvas, &columns, top);
    let mut group = None;
    for place in places(rows) {
        if group != Some(place.by.as_str()) {
            group = Some(place.by.as_str());
            y += 15.0;
            // Bold letters are up to a sixth wider.
            let name = fitted(&capitalised(&place.by), SMALL, 0.8 * (right - left));
            canvas.text(Text::new(name, [left, y], SMALL, TextAlign::Left).bold());
            y += 5.0;
        }
        let room = columns.first - left - 14.0;
        let name = Text::new(
            fitted(&place.place, SMALL, room),
            [left + 8.0, y + 0.5 * ROW_HEIGHT + 3.5],
            SMALL,
            TextAlign::Left,
        );
        canvas.text(name);
        for (index, (axis, _)) in columns.axes.iter().enumerate() {
            let is_cell = |row: &&PlaceRow| {
                row.by == place.by && row.place == place.place && row.axis == *axis
            };
            if let Some(row) = rows.iter().find(is_cell) {
                cells(canvas, &columns, row, [columns.first + pitch * index as f64, y]);
            }
        }
        y += ROW_HEIGHT;
    }
    y
}

/// Names of the axes, and below each which cell is which.
fn headings(canvas: &mut Canvas, columns: &Columns, top: f64) -> f64 {
    for (index, (_, name)) in columns.axes.iter().enumerate() {
        let x = columns.first + columns.pitch * index as f64;
        let middle = x + 0.5 * (columns.pitch - 8.0);
        canvas.text(Text::new(*name, [middle, top], TEXT, TextAlign::Centre).bold());
        canvas.line(&[[x, top + 4.0], [x + columns.pitch - 8.0, top + 4.0]], HAIR, GREY, &[]);
        let names: &[&str] = if columns.has_after { &["before", "after"] } else { &["before"] };
        for (turn, name) in names.iter().enumerate() {
            let x = x + columns.wide * (turn as f64 + 0.5);
            let size = if columns.wide < 40.0 { 7.6 } else { SMALL };
            canvas.text(Text::new(*name, [x, top + 15.0], size, TextAlign::Centre).colour(GREY));
        }
    }
    top + 15.0
}

/// Before and after at one place along one axis.
fn cells(canvas: &mut Canvas, columns: &Columns, row: &PlaceRow, [x, y]: CanvasPoint) {
    let before_and_after = [(row.rms_before_m, row.p_before), (row.rms_after_m, row.p_after)];
    for (turn, (rms_m, p)) in
        before_and_after.into_iter().take(if columns.has_after { 2 } else { 1 }).enumerate()
    {
        let [x0, x1] = [x + columns.wide * turn as f64, x + columns.wide * (turn + 1) as f64];
        let ratio = rms_m / row.floor_m;
        let (ground, ink) = cell(ratio);
        canvas.rectangle([x0 + 0.6, y + 0.6], [x1 - 0.6, y + ROW_HEIGHT - 0.6], ground, 1.0);
        let significant = columns.marked[turn] && p < SIGNIFICANCE_LEVEL;
        // In narrow cells the number makes room for the dot.
        let (aside, corner, radius) =
            if columns.wide < 40.0 { (2.0, 3.0, 1.3) } else { (0.0, 5.0, 1.7) };
        let middle = 0.5 * (x0 + x1) - if significant { aside } else { 0.0 };
        let number = Text::new(
            ratio_text(ratio),
            [middle, y + 0.5 * ROW_HEIGHT + 3.5],
            SMALL,
            TextAlign::Centre,
        );
        canvas.text(Text { bold: significant, ..number.colour(ink) });
        if significant {
            canvas.disc([x1 - corner, y + corner], radius, ink, 1.0);
        }
    }
}

/// A sample cell for the key: what the dot and bold type say.
pub(super) fn key(canvas: &mut Canvas, [x, y]: CanvasPoint) {
    canvas.disc([x + 3.0, y - 3.5], 1.7, INK, 1.0);
    let label = "bold, with a dot: more than noise (p < 0.001, corrected for all places)";
    let room = canvas.width - x - 24.0;
    canvas.text(Text::new(fitted(label, SMALL, room), [x + 10.0, y], SMALL, TextAlign::Left));
}

/// Each place once, in order of appearance, groups together.
fn places(rows: &[PlaceRow]) -> Vec<&PlaceRow> {
    let mut groups: Vec<&str> = Vec::new();
    let mut distinct_places: Vec<&PlaceRow> = Vec::new();
    for row in rows {
        if !groups.contains(&row.by.as_str()) {
            groups.push(&row.by);
        }
        if !distinct_places.iter().any(|other| other.by == row.by && other.place == row.place) {
            distinct_places.push(row);
        }
    }
    distinct_places.sort_by_key(|row| groups.iter().position(|group| *group == row.by));
    distinct_places
}
