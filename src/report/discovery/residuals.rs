//! What is left at the tip on held-out trials: measured minus model against time, one line of
//! panels an axis, with the band in which noise stays.

use std::collections::BTreeMap;

use super::super::style::{
    BLUE, Colour, DASHED, GREEN, GREY, HAIR, INK, LEFT_MARGIN, SMALL, VERMILION,
};
use super::DiscoveryReport;
use crate::data::findings::ResidualRow;
use crate::report::drawing::{Axis, Canvas, LegendEntry, Panel, Text, TextAlign, legend};

/// Names of the axes.
pub(super) const AXES: [&str; 3] = ["x", "y", "z"];
const PANEL_HEIGHT: f64 = 104.0;
/// White noise stays within so many standard deviations for 95 % of the time.
const BAND_SIGMAS: f64 = 1.96;
/// Opacity of that band.
const BAND_OPACITY: f64 = 0.22;

/// The picture at a width in hundredths of an inch; none where no trial was held out.
pub(super) fn draw(report: &DiscoveryReport, width: f64) -> Option<Canvas> {
    let mut trials = held_out(report.residuals);
    // Of the tip, or of the first point where the tip was not tracked.
    let place = report.residuals.iter().map(|row| &row.point).min()?;
    trials.values_mut().for_each(|rows| rows.retain(|row| row.point == *place));
    if trials.is_empty() {
        return None;
    }
    let max_trials = if width > 500.0 { 4 } else { 1 };
    let shown: Vec<(&u64, &Vec<&ResidualRow>)> = trials.iter().take(max_trials).collect();
    let gap = 22.0;
    let wide = (width - LEFT_MARGIN - 12.0 - gap * (shown.len() - 1) as f64) / shown.len() as f64;
    let mut canvas = Canvas::new(width, 1e5);
    let has_after = report.changed();
    let mut top = keys(&mut canvas, has_after) + 26.0;
    let seconds = Axis::covering(
        "time in trial (s)",
        shown.iter().flat_map(|(_, rows)| rows.iter().map(|row| row.time_s)),
        5,
    );
    for axis in 0..3 {
        let sigma_mm = 1e3 * report.findings.noise.sigma_m[axis];
        let y = millimetres(axis, &shown, sigma_mm);
        for (column, (trial, rows)) in shown.iter().enumerate() {
            let panel = canvas.panel(Panel {
                corner: [LEFT_MARGIN + column as f64 * (wide + gap), top],
                size: [wide, PANEL_HEIGHT],
                x: if axis == 2 { seconds.clone() } else { seconds.bare() },
                y: if column == 0 { y.clone() } else { y.bare() },
                title: if axis == 0 { format!("trial {trial}") } else { String::new() },
            });
            curves(&mut canvas, &panel, rows, axis, sigma_mm, has_after);
        }
        top += PANEL_HEIGHT + 16.0;
    }
    top += 32.0;
    if trials.len() > shown.len() {
        let note = format!("{} of {} held-out trials", shown.len(), trials.len());
        canvas.text(Text::new(note, [width - 12.0, top], SMALL, TextAlign::Right).colour(GREY));
    }
    canvas.height = (top + 10.0).ceil();
    Some(canvas)
}

/// What the lines and the band are. Returns the last baseline.
fn keys(canvas: &mut Canvas, has_after: bool) -> f64 {
    let keys =
        [(LegendEntry::Line(VERMILION, DASHED), "before"), (LegendEntry::Line(BLUE, &[]), "after")];
    let right = canvas.width - 8.0;
    legend(canvas, [LEFT_MARGIN, 18.0], right, &keys[..if has_after { 2 } else { 1 }]);
    let x = LEFT_MARGIN + if has_after { 150.0 } else { 80.0 };
    canvas.rectangle([x, 8.0], [x + 22.0, 20.0], GREEN, BAND_OPACITY);
    canvas.text(Text::new("95 % of the noise", [x + 27.0, 18.0], SMALL, TextAlign::Left));
    18.0
}

/// Rows of the trials that took no part in naming or fitting, in order of time.
pub(super) fn held_out(rows: &[ResidualRow]) -> BTreeMap<u64, Vec<&ResidualRow>> {
    let mut trials: BTreeMap<u64, Vec<&ResidualRow>> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.held_out && row.time_s.is_finite()) {
        trials.entry(row.trial).or_default().push(row);
    }
    trials.values_mut().for_each(|rows| rows.sort_by(|a, b| a.time_s.total_cmp(&b.time_s)));
    trials
}

/// The axis of residuals along one direction: both curves, nothing and the band.
fn millimetres(axis: usize, trials: &[(&u64, &Vec<&ResidualRow>)], sigma_mm: f64) -> Axis {
    let values = trials.iter().flat_map(|(_, rows)| rows.iter());
    let values = values.flat_map(|row| [1e3 * row.before_m()[axis], 1e3 * row.after_m()[axis]]);
    let band = [BAND_SIGMAS * sigma_mm, -BAND_SIGMAS * sigma_mm, 0.0];
    Axis::covering(&format!("{} (mm)", AXES[axis]), values.chain(band), 4)
}

/// Band, zero, before and after.
fn curves(
    canvas: &mut Canvas,
    panel: &Panel,
    rows: &[&ResidualRow],
    axis: usize,
    sigma_mm: f64,
    has_after: bool,
) {
    let half = BAND_SIGMAS * sigma_mm;
    if half.is_finite() {
        canvas.rectangle(
            panel.at(panel.x.low, half),
            panel.at(panel.x.high, -half),
            GREEN,
            BAND_OPACITY,
        );
    }
    panel.line(canvas, &[[panel.x.low, 0.0], [panel.x.high, 0.0]], INK, &[], HAIR);
    let mut curve = |residual: fn(&ResidualRow) -> [f64; 3], colour: Colour, width: f64, dash| {
        // A gap in the recording is a gap in the line.
        let points: Vec<[f64; 2]> =
            rows.iter().map(|row| [row.time_s, 1e3 * residual(row)[axis]]).collect();
        for piece in points.split(|point| !point[1].is_finite()).filter(|piece| !piece.is_empty()) {
            panel.line(canvas, piece, colour, dash, width);
        }
    };
    curve(ResidualRow::before_m, VERMILION, 1.2, DASHED);
    if has_after {
        curve(ResidualRow::after_m, BLUE, 1.3, &[]);
    }
}
