//! The gap: tip error of the model as given and of the answer, beside the noise floor.

use super::super::style::{BLUE, Colour, DASHED, INK, SMALL, VERMILION};
use super::DiscoveryReport;
use super::format::{fitted, millimetres, times};
use crate::report::drawing::{Axis, Canvas, Panel, Text, TextAlign, text_width};

const BAR_HEIGHT: f64 = 13.0;
const ROW_HEIGHT: f64 = 19.0;

/// A bar: name, size in metres, colour.
struct Bar {
    name: String,
    size_m: f64,
    colour: Colour,
}

/// The picture at a width in hundredths of an inch; none where no gap was measured.
pub(super) fn draw(report: &DiscoveryReport, width: f64) -> Option<Canvas> {
    let floor_m = report.findings.noise_floor_m;
    let bars = bars(report);
    let sizes = || bars.iter().map(|bar| bar.size_m).filter(|size| size.is_finite());
    sizes().next()?;
    let label = if width > 500.0 { 210.0 } else { 118.0 };
    let value = 112.0;
    let mut canvas = Canvas::new(width, 1e5);
    let title = 4.0;
    let high = ROW_HEIGHT * bars.len() as f64 + 6.0;
    canvas
        .text(Text::new("On held-out trials", [12.0, title + 14.0], SMALL, TextAlign::Left).bold());
    let panel = canvas.panel(Panel {
        corner: [label, title + 22.0],
        size: [width - label - value, high],
        x: Axis::covering(
            "rms tip error (mm)",
            sizes().chain([floor_m, 0.0]).map(|size| 1e3 * size),
            4,
        ),
        y: Axis::bare_to(1.0),
        title: String::new(),
    });
    let mut y = panel.corner[1] + 6.0;
    for bar in &bars {
        y = draw_bar(&mut canvas, &panel, bar, y, floor_m);
    }
    noise(&mut canvas, &panel, high, floor_m);
    canvas.height = (panel.corner[1] + high + 42.0).ceil();
    Some(canvas)
}

/// Before and after.
fn bars(report: &DiscoveryReport) -> Vec<Bar> {
    let gap = &report.findings.gap;
    let before = Bar { name: report.before().to_owned(), size_m: gap.before_m, colour: VERMILION };
    let names: Vec<&str> =
        report.findings.effects.iter().map(|effect| effect.name.as_str()).collect();
    let name = if names.len() == 1 {
        format!("with {}", names[0])
    } else {
        "with the effects found".to_owned()
    };
    let after = report.changed().then_some(Bar { name, size_m: gap.after_m, colour: BLUE });
    std::iter::once(before).chain(after).collect()
}

fn draw_bar(canvas: &mut Canvas, panel: &Panel, bar: &Bar, y: f64, floor_m: f64) -> f64 {
    let base = y + 0.5 * BAR_HEIGHT + 3.6;
    let name = fitted(&bar.name, SMALL, panel.corner[0] - 22.0);
    canvas.text(Text::new(name, [panel.corner[0] - 8.0, base], SMALL, TextAlign::Right));
    let zero = panel.at(0.0, 0.0)[0];
    let end = if bar.size_m.is_finite() { panel.at(1e3 * bar.size_m, 0.0)[0] } else { zero };
    canvas.rectangle([zero, y], [end.max(zero + 0.6), y + BAR_HEIGHT], bar.colour, 1.0);
    let right = canvas.width - 10.0;
    let values = [(right - 42.0, millimetres(bar.size_m)), (right, times(bar.size_m, floor_m))];
    for (x, words) in values {
        canvas.text(Text::new(words, [x, base], SMALL, TextAlign::Right));
    }
    y + ROW_HEIGHT
}

/// The noise floor.
fn noise(canvas: &mut Canvas, panel: &Panel, high: f64, floor_m: f64) {
    let (x, top) = (panel.at(1e3 * floor_m, 0.0)[0], panel.corner[1]);
    if !x.is_finite() {
        return;
    }
    canvas.line(&[[x, top], [x, top + high]], 1.3, INK, DASHED);
    canvas.line(&[[x, top - 6.0], [x, top]], 1.3, INK, &[]);
    let label = format!("noise floor {}", millimetres(floor_m));
    let wide = text_width(&label, SMALL, false);
    let at = (x - 0.5 * wide).clamp(130.0, (canvas.width - 10.0 - wide).max(130.0));
    canvas.text(Text::new(label, [at, top - 9.0], SMALL, TextAlign::Left));
}
