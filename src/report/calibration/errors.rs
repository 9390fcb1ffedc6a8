//! Error on positions that the fit has not seen, of the calibrated model and of what a laboratory
//! would use instead.

use super::CalibrationReport;
use crate::report::discovery::format::millimetres;
use crate::report::drawing::{Axis, Canvas, LegendEntry, Panel, Text, TextAlign, legend};
use crate::report::style::{BLUE, Colour, DASHED, INK, Marker, SMALL, TALL};

const ROW_HEIGHT: f64 = 21.0;
const BAR_HEIGHT: f64 = 14.0;
/// Grey of a model that is not ours.
const OTHER: Colour = [170, 170, 170];

/// The picture at a width in hundredths of an inch; none where nothing was held out.
pub(super) fn draw(report: &CalibrationReport, width: f64) -> Option<Canvas> {
    let held_out = report.findings.held_out.as_ref()?;
    let models: Vec<_> = held_out.models.iter().filter(|model| model.rms_m.is_finite()).collect();
    let label = if width > 500.0 { 190.0 } else { 130.0 };
    let high = ROW_HEIGHT * models.len() as f64 + 8.0;
    let mut canvas = Canvas::new(width, TALL);
    let mut keys = vec![
        (LegendEntry::Marker(Marker::Square, BLUE, false), "the fitted model".to_owned()),
        (LegendEntry::Marker(Marker::Square, OTHER, false), "others".to_owned()),
    ];
    if let Some(noise) = &report.findings.noise {
        keys.push((LegendEntry::Line(INK, DASHED), noise_words(&noise.from)));
    }
    let keys: Vec<(LegendEntry, &str)> =
        keys.iter().map(|(entry, words)| (*entry, words.as_str())).collect();
    let top = legend(&mut canvas, [10.0, 16.0], width - 8.0, &keys) + 14.0;
    canvas.height = (top + high + 44.0).ceil();
    let panel = canvas.panel(Panel {
        corner: [label, top],
        size: [width - label - 78.0, high],
        x: Axis::from_zero("rms error (mm)", scale_mm(&models), 4),
        y: Axis::bare_to(1.0),
        title: String::new(),
    });
    let zero = panel.at(0.0, 0.0)[0];
    for (index, model) in models.iter().enumerate() {
        let y = panel.corner[1] + 6.0 + ROW_HEIGHT * index as f64;
        let end = panel.at(1e3 * model.rms_m, 0.0)[0].min(panel.corner[0] + panel.size[0]);
        let colour = if index == 0 { BLUE } else { OTHER };
        canvas.rectangle([zero, y], [end.max(zero + 0.6), y + BAR_HEIGHT], colour, 1.0);
        let base = y + 0.5 * BAR_HEIGHT + 3.6;
        canvas.text(Text::new(&model.name, [label - 8.0, base], SMALL, TextAlign::Right));
        canvas.text(Text::new(
            millimetres(model.rms_m),
            [width - 8.0, base],
            SMALL,
            TextAlign::Right,
        ));
    }
    if let Some(noise) = &report.findings.noise {
        let x = panel.at(1e3 * noise.noise_m, 0.0)[0];
        canvas.line(&[[x, panel.corner[1]], [x, panel.corner[1] + high]], 1.3, INK, DASHED);
    }
    Some(canvas)
}

/// Where the noise is known from, in two or three words.
pub(super) fn noise_words(from: &str) -> String {
    if from.ends_with("an upper bound") {
        "noise, upper bound".to_owned()
    } else {
        "noise of the measurement".to_owned()
    }
}

/// The scale: up to one and a half times the second largest, so that one failure does not flatten
/// the others.
fn scale_mm(models: &[&crate::data::calibration::ModelError]) -> impl Iterator<Item = f64> {
    let mut sizes: Vec<f64> = models.iter().map(|model| 1e3 * model.rms_m).collect();
    sizes.sort_by(f64::total_cmp);
    let second = sizes.len().checked_sub(2).map_or(f64::INFINITY, |index| 1.5 * sizes[index]);
    sizes.into_iter().map(move |size| size.min(second)).chain([0.0])
}
