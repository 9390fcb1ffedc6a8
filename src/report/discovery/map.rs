//! The map of disagreement: at which places model and measurement differ, along which axis and by
//! how much, before and after; and the same in space.

use super::super::style::{GREY, SMALL};
use super::{DiscoveryReport, arrows, heat, scale};
use crate::report::drawing::{Canvas, Text, TextAlign};

/// The picture at a width in hundredths of an inch; none where there is neither a place nor a
/// sample.
pub(super) fn draw(report: &DiscoveryReport, width: f64) -> Option<Canvas> {
    let DiscoveryReport { places, residuals, .. } = report;
    if places.is_empty() && residuals.is_empty() {
        return None;
    }
    let mut canvas = Canvas::new(width, 0.0);
    // Nothing is cut off while the height is not known.
    canvas.height = 1e5;
    let heading = "residual over the noise floor";
    let mut y = scale::key(&mut canvas, [12.0, 18.0], width - 8.0, heading);
    let has_after = report.changed();
    if !places.is_empty() {
        y += 17.0;
        heat::key(&mut canvas, [12.0, y]);
        y = heat::draw(&mut canvas, report, y + 24.0) + 12.0;
    }
    y = arrows::draw(&mut canvas, residuals, report.findings.noise_floor_m, has_after, y);
    if has_after {
        y += 16.0;
        let note =
            format!("before: the {}; after: the model with the effects found", report.before());
        canvas.text(Text::new(note, [12.0, y], SMALL, TextAlign::Left).colour(GREY));
    }
    canvas.height = (y + 14.0).ceil();
    Some(canvas)
}
