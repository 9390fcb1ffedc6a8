//! Where they disagree, in space: from each measured tip which way and how far it lies from the
//! model's, seen from the side and from above, without and with the effects.

use super::super::style::{GREY, SMALL};
use super::format::number;
use super::residuals::AXES;
use super::scale;
use crate::base::Point3;
use crate::data::findings::ResidualRow;
use crate::math::summary::quantile;
use crate::report::drawing::{Axis, Canvas, CanvasPoint, Panel, Text, TextAlign, range};

/// Arrows in a panel: more would cover each other.
const MAX_ARROWS: usize = 160;
/// Horizontal and vertical axis of each view: the robot points to the right.
const VIEWS: [(usize, usize); 2] = [(2, 0), (2, 1)];
/// Long arrows (the 90th percentile of those before) are about this long, hundredths of an inch.
const ARROW_LENGTH: f64 = 20.0;

/// A sample: measured tip and residual, metres.
struct ArrowSample {
    tip_m: Point3,
    before_m: Point3,
    after_m: Point3,
}

/// The samples that have a place and a residual.
fn samples(rows: &[ResidualRow]) -> Vec<ArrowSample> {
    let sample = |row: &ResidualRow| ArrowSample {
        tip_m: [row.tip_x_m, row.tip_y_m, row.tip_z_m],
        before_m: row.before_m(),
        after_m: row.after_m(),
    };
    let is_complete = |sample: &ArrowSample| {
        sample.tip_m.iter().chain(&sample.before_m).all(|part| part.is_finite())
    };
    rows.iter().map(sample).filter(is_complete).collect()
}

fn size(vector: &Point3) -> f64 {
    vector.iter().map(|part| part * part).sum::<f64>().sqrt()
}

/// Draws the views from `top` down and returns where they end; nothing for no samples.
pub(super) fn draw(
    canvas: &mut Canvas,
    rows: &[ResidualRow],
    floor_m: f64,
    has_after: bool,
    top: f64,
) -> f64 {
    let samples = samples(rows);
    if samples.is_empty() {
        return top;
    }
    let wide = canvas.width > 500.0;
    let in_row = if wide && has_after { 4.0 } else { 2.0 };
    let spans = spans_mm(&samples);
    let gap = 56.0;
    let room = ((canvas.width - 12.0 - gap * in_row) / in_row).min(250.0);
    let length = |axis: usize| spans[axis][1] - spans[axis][0];
    let tall = length(0);
    let scale = (room / length(2)).min(if wide { 230.0 } else { 190.0 } / tall);
    let sizes: Vec<f64> = samples.iter().map(|sample| size(&sample.before_m)).collect();
    let magnified = magnification(ARROW_LENGTH / (1e3 * scale * quantile(&sizes, 0.9)).max(1e-9));
    let moments: &[&str] = if has_after { &["before", "after"] } else { &["before"] };
    let high = scale * tall;
    let mut left = gap - 4.0;
    let mut y = top + 34.0;
    for (view, (across, up)) in VIEWS.into_iter().enumerate() {
        for (turn, moment) in moments.iter().enumerate() {
            let panel = canvas.panel(Panel {
                corner: [left, y],
                size: [scale * length(across), high],
                x: axis(across, &spans, scale),
                y: axis(up, &spans, scale),
                title: format!("{} over {}, {moment}", AXES[up], AXES[across]),
            });
            let residual =
                |sample: &ArrowSample| if turn == 0 { sample.before_m } else { sample.after_m };
            arrows(canvas, &panel, &samples, residual, [across, up], magnified, floor_m);
            left += room + gap;
        }
        if !wide && has_after && view == 0 {
            left = gap - 4.0;
            y += high + 72.0;
        }
    }
    let bottom = y + high + 46.0;
    note(canvas, magnified, samples.len(), bottom);
    bottom + if wide { 0.0 } else { 14.0 }
}

fn note(canvas: &mut Canvas, magnified: f64, count: usize, y: f64) {
    let lines = [
        format!(
            "from the measured tip, away from the simulated tip, {} × as long",
            number(magnified, 1)
        ),
        match count.div_ceil(MAX_ARROWS) {
            1 => String::new(),
            stride => format!("one sample in {stride} of {count}"),
        },
    ];
    let text =
        |words: String, at: CanvasPoint| Text::new(words, at, SMALL, TextAlign::Left).colour(GREY);
    if canvas.width > 500.0 {
        let joined: Vec<&str> =
            lines.iter().map(String::as_str).filter(|line| !line.is_empty()).collect();
        canvas.text(text(joined.join("; "), [12.0, y]));
    } else {
        for (index, line) in lines.into_iter().enumerate() {
            canvas.text(text(line, [12.0, y + 14.0 * index as f64]));
        }
    }
}

/// 1, 2 or 5 times a power of ten, not above `wanted` and not below 1.
fn magnification(wanted: f64) -> f64 {
    let power = 10f64.powf(wanted.clamp(1.0, 1e4).log10().floor());
    [5.0, 2.0, 1.0].into_iter().map(|step| step * power).find(|step| *step <= wanted).unwrap_or(1.0)
}

fn axis(axis: usize, spans: &[[f64; 2]; 3], scale: f64) -> Axis {
    let ticks = (scale * (spans[axis][1] - spans[axis][0]) / 42.0).round().max(2.0) as usize;
    Axis::exact(&format!("{} (mm)", AXES[axis]), spans[axis][0], spans[axis][1], ticks)
}

/// What each axis shows, millimetres: x and y alike, and z at least half as much, so that a path
/// along one axis has a picture too.
fn spans_mm(samples: &[ArrowSample]) -> [[f64; 2]; 3] {
    let tips_mm = |axis: usize| samples.iter().map(move |sample| 1e3 * sample.tip_m[axis]);
    let (low, high) = range(tips_mm(0).chain(tips_mm(1)));
    let room = (0.08 * (high - low)).max(15.0);
    let across = [low - room, high + room];
    let (low, high) = range(tips_mm(2));
    let half = (0.54 * (high - low)).max(0.3 * (across[1] - across[0])).max(15.0);
    let middle = 0.5 * (low + high);
    [across, across, [middle - half, middle + half]]
}

/// The arrows of a panel, the small ones first.
fn arrows(
    canvas: &mut Canvas,
    panel: &Panel,
    samples: &[ArrowSample],
    residual: impl Fn(&ArrowSample) -> Point3,
    [across, up]: [usize; 2],
    magnified: f64,
    floor_m: f64,
) {
    let stride = samples.len().div_ceil(MAX_ARROWS).max(1);
    let mut shown: Vec<&ArrowSample> = samples.iter().step_by(stride).collect();
    shown.retain(|sample| residual(sample).iter().all(|part| part.is_finite()));
    shown.sort_by(|a, b| size(&residual(a)).total_cmp(&size(&residual(b))));
    for sample in shown {
        let gap = residual(sample);
        let colour = scale::mark(size(&gap) / floor_m);
        let end = |axis: usize| 1e3 * (sample.tip_m[axis] + magnified * gap[axis]);
        let from = panel.at(1e3 * sample.tip_m[across], 1e3 * sample.tip_m[up]);
        arrow(canvas, from, panel.at(end(across), end(up)), colour);
    }
}

/// A dot where the tip is, and an arrow with a head where it is long enough for one.
fn arrow(
    canvas: &mut Canvas,
    from: CanvasPoint,
    to: CanvasPoint,
    colour: super::super::style::Colour,
) {
    let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    let length = dx.hypot(dy);
    canvas.disc(from, 1.1, colour, 1.0);
    if length < 2.0 {
        return;
    }
    let [u, v] = [dx / length, dy / length];
    let head = (0.4 * length).min(4.5);
    let neck = [to[0] - head * u, to[1] - head * v];
    canvas.line(&[from, neck], 0.9, colour, &[]);
    let side = 0.42 * head;
    canvas.area(
        vec![
            to,
            [neck[0] - side * v, neck[1] + side * u],
            [neck[0] + side * v, neck[1] - side * u],
        ],
        colour,
        1.0,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrows_are_magnified_by_round_numbers() {
        assert_eq!(
            [0.3, 1.0, 1.9, 2.0, 7.0, 23.0, 1e9].map(magnification),
            [1.0, 1.0, 1.0, 2.0, 5.0, 20.0, 50000.0]
        );
    }
}
