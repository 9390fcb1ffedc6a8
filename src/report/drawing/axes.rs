//! Axes and panels: from data to points on the canvas.

use super::canvas::{Canvas, CanvasPoint, Text, TextAlign};
use super::paint::text_width;
use crate::report::style::{
    BAND, Colour, Dash, GRID, HAIR, HALF_CAP, INK, LINE, Look, MARKER, SMALL, TEXT,
};

/// One direction of a panel.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Axis {
    pub(crate) label: String,
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// Value and label of each tick.
    pub(crate) ticks: Vec<(f64, String)>,
}

impl Axis {
    /// An axis that covers the finite ones of `values`, with its ends on ticks and about `wanted`
    /// ticks.
    pub(crate) fn covering(label: &str, values: impl Iterator<Item = f64>, wanted: usize) -> Axis {
        let (low, high) = range(values);
        let step = nice_step(low, high, wanted);
        // An end on a tick but for rounding needs no further step.
        let low = (low / step + 1e-9).floor() * step;
        let high = (high / step - 1e-9).ceil() * step;
        Axis::between(label, low, high, step)
    }

    /// An axis from `low` to `high` exactly, with about `wanted` ticks.
    pub(crate) fn exact(label: &str, low: f64, high: f64, wanted: usize) -> Axis {
        Axis::between(label, low, high, nice_step(low, high, wanted))
    }

    fn between(label: &str, low: f64, high: f64, step: f64) -> Axis {
        let digits = (-step.log10().floor()).max(0.0) as usize;
        // A step of 2.5 has one more digit than its power of ten.
        let shown = (step * 10f64.powi(digits as i32)).fract();
        let digits = if shown > 1e-6 && shown < 1.0 - 1e-6 { digits + 1 } else { digits };
        let first = (low / step - 1e-6).ceil() as i64;
        let last = (high / step + 1e-6).floor() as i64;
        let ticks = (first..=last).map(|number| {
            let value = number as f64 * step;
            (value, signed(value, digits))
        });
        Axis { label: label.to_owned(), low, high, ticks: ticks.collect() }
    }

    /// An axis with names at 0, 1, 2, …
    pub(crate) fn categories(label: &str, names: &[String]) -> Axis {
        let ticks =
            names.iter().enumerate().map(|(place, name)| (place as f64, name.clone())).collect();
        Axis { label: label.to_owned(), low: -0.4, high: names.len() as f64 - 0.6, ticks }
    }

    /// An axis of logarithms to base ten that covers `values` (positive), its ends on powers of
    /// ten.
    pub(crate) fn decades(label: &str, values: impl Iterator<Item = f64>) -> Axis {
        let (low, high) = range(values.map(f64::log10));
        let (low, high) = (low.floor(), high.ceil().max(low.floor() + 1.0));
        // Skip labels that would overlap.
        let step = ((high - low) / 6.0).ceil().max(1.0) as usize;
        let ticks = (low as i64..=high as i64)
            .step_by(step)
            .map(|power| (power as f64, power_of_ten(power)));
        Axis { label: label.to_owned(), low, high, ticks: ticks.collect() }
    }

    /// An axis from zero that covers `values`: distances, whose spread may reach below.
    pub(crate) fn from_zero(label: &str, values: impl Iterator<Item = f64>, wanted: usize) -> Axis {
        Axis::covering(label, values.filter(|value| *value > 0.0).chain([0.0]), wanted)
    }

    /// An axis of logarithms to base ten that covers `values` (positive), its ends on 1, 2 or 5
    /// times a power of ten, with as many of these for ticks as fit in `long`.
    pub(crate) fn log(label: &str, values: impl Iterator<Item = f64>, long: f64) -> Axis {
        const STEPS: [f64; 3] = [1.0, 2.0, 5.0];
        let place =
            |step: i64| STEPS[step.rem_euclid(3) as usize].log10() + step.div_euclid(3) as f64;
        let (low, high) = range(values.filter(|value| *value > 0.0).map(f64::log10));
        let near = (3.0 * low).floor() as i64 - 1;
        let first = (near..near + 4).rev().find(|step| place(*step) <= low + 1e-9).unwrap_or(near);
        let far = (3.0 * high).ceil() as i64 + 1;
        let last = (far - 4..=far).find(|step| place(*step) >= high - 1e-9).unwrap_or(far);
        let last = last.max(first + 1);
        let whole = |step: &i64| step.rem_euclid(3) == 0;
        let room = ((long / 26.0) as usize).max(2);
        let all: Vec<i64> = (first..=last).collect();
        let powers: Vec<i64> = all.iter().copied().filter(whole).collect();
        let shown = if all.len() <= room || powers.len() < 2 { all } else { powers };
        let every = shown.len().div_ceil(room).max(1);
        let label_of = |step: i64| {
            let power = power_of_ten(step.div_euclid(3));
            if whole(&step) { power } else { plain(10f64.powf(place(step))) }
        };
        let ticks = shown.into_iter().step_by(every).map(|step| (place(step), label_of(step)));
        Axis {
            label: label.to_owned(),
            low: place(first),
            high: place(last),
            ticks: ticks.collect(),
        }
    }

    /// An axis of logarithms with a tick at each of these sizes, from a little before the first to
    /// a little after the last; sizes of zero stand a step before the others.
    pub(crate) fn sizes(label: &str, sizes: &[u64]) -> Axis {
        let positive: Vec<u64> = sizes.iter().copied().filter(|size| *size > 0).collect();
        let (low, high) = range(positive.iter().map(|size| (*size as f64).log10()));
        let step = 0.14 * (high - low);
        let place = |size: u64| if size > 0 { (size as f64).log10() } else { low - step };
        let ticks: Vec<(f64, String)> =
            sizes.iter().map(|size| (place(*size), thousands(*size))).collect();
        let first = ticks.iter().map(|(place, _)| *place).fold(low, f64::min);
        let room = 0.05 * (high - low);
        Axis { label: label.to_owned(), low: first - room, high: high + room, ticks }
    }

    /// An axis from zero without label and ticks.
    pub(crate) fn bare_to(high: f64) -> Axis {
        Axis { label: String::new(), low: 0.0, high, ticks: Vec::new() }
    }

    /// The axis without label and tick labels, for a panel whose neighbour shows them.
    pub(crate) fn bare(&self) -> Axis {
        let ticks = self.ticks.iter().map(|(value, _)| (*value, String::new())).collect();
        Axis { label: String::new(), ticks, ..self.clone() }
    }

    fn share(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }
}

/// 0.01, 0.1, 1, 10, …; large and small ones as powers.
fn power_of_ten(power: i64) -> String {
    match power {
        0..=4 => format!("{}", 10_i64.pow(power as u32)),
        -4..=-1 => format!("{:.*}", power.unsigned_abs() as usize, 10f64.powi(power as i32)),
        _ => {
            let digits = ["⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"];
            let raised: String = power
                .unsigned_abs()
                .to_string()
                .bytes()
                .map(|digit| digits[usize::from(digit - b'0')])
                .collect();
            format!("10{}{raised}", if power < 0 { "⁻" } else { "" })
        }
    }
}

/// A positive number in plain notation, one significant digit.
fn plain(value: f64) -> String {
    let digits = (-value.log10().floor()).max(0.0) as usize;
    format!("{value:.digits$}")
}

/// A count with commas between thousands.
pub(crate) fn thousands(count: u64) -> String {
    let digits = count.to_string();
    let groups: Vec<&str> = digits
        .as_bytes()
        .rchunks(3)
        .rev()
        .map(|group| std::str::from_utf8(group).unwrap_or_default())
        .collect();
    groups.join(",")
}

/// A number with a minus sign (U+2212), without one before zero.
pub(crate) fn signed(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let zero = text.chars().all(|letter| matches!(letter, '-' | '0' | '.'));
    if zero { text.replace('-', "") } else { text.replace('-', "−") }
}

/// Smallest and largest of the finite values, widened when they are equal.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let finite = values.filter(|value| value.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    if low > high {
        return (0.0, 1.0);
    }
    let room = if high - low > 1e-12 * (1.0 + high.abs()) { 0.0 } else { 0.5 + 0.1 * high.abs() };
    (low - room, high + room)
}

fn nice_step(low: f64, high: f64, wanted: usize) -> f64 {
    let raw = (high - low).max(1e-12) / wanted.max(1) as f64;
    let power = 10f64.powf(raw.log10().floor());
    // Steps that people count in; a thousandth is left to rounding.
    let steps = [1.0, 2.0, 2.5, 5.0, 10.0];
    steps
        .into_iter()
        .map(|step| step * power)
        .find(|step| *step >= raw * 0.999)
        .unwrap_or(10.0 * power)
}

impl Canvas {
    /// Draws a panel, on which the data come.
    pub(crate) fn panel(&mut self, panel: Panel) -> Panel {
        panel.draw(self);
        panel
    }
}

/// A frame with two axes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Panel {
    /// Upper left corner of the frame.
    pub(crate) corner: CanvasPoint,
    /// Width and height of the frame.
    pub(crate) size: [f64; 2],
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    pub(crate) title: String,
}

impl Panel {
    /// Position of a data point.
    pub(crate) fn at(&self, x: f64, y: f64) -> CanvasPoint {
        let [left, top] = self.corner;
        [left + self.size[0] * self.x.share(x), top + self.size[1] * (1.0 - self.y.share(y))]
    }

    /// Draws grid, axes, ticks, labels and title, below the data.
    pub(crate) fn draw(&self, canvas: &mut Canvas) {
        let [left, top] = self.corner;
        let [right, bottom] = [left + self.size[0], top + self.size[1]];
        let mut free = f64::NEG_INFINITY;
        for (value, label) in &self.x.ticks {
            let x = self.at(*value, self.y.low)[0];
            canvas.line(&[[x, top], [x, bottom]], HAIR, GRID, &[]);
            canvas.line(&[[x, bottom], [x, bottom + 3.5]], HAIR, INK, &[]);
            // A label that would touch the one before is left out.
            let half = 0.5 * text_width(label, SMALL, false);
            if x - half > free {
                canvas.text(Text::new(label, [x, bottom + 5.0 + SMALL], SMALL, TextAlign::Centre));
                free = x + half + 4.0;
            }
        }
        let mut widest: f64 = 0.0;
        for (value, label) in &self.y.ticks {
            let y = self.at(self.x.low, *value)[1];
            canvas.line(&[[left, y], [right, y]], HAIR, GRID, &[]);
            canvas.line(&[[left - 3.5, y], [left, y]], HAIR, INK, &[]);
            canvas.text(Text::new(
                label,
                [left - 6.0, y + HALF_CAP * SMALL],
                SMALL,
                TextAlign::Right,
            ));
            widest = widest.max(text_width(label, SMALL, false));
        }
        canvas.line(&[[left, top], [left, bottom], [right, bottom]], HAIR, INK, &[]);
        let middle = [(left + right) / 2.0, (top + bottom) / 2.0];
        let below =
            if self.x.ticks.iter().all(|(_, label)| label.is_empty()) { 6.0 } else { 9.0 + SMALL };
        canvas.text(Text::new(
            &self.x.label,
            [middle[0], bottom + below + TEXT],
            TEXT,
            TextAlign::Centre,
        ));
        let beside = left - 13.0 - widest;
        canvas
            .text(Text::new(&self.y.label, [beside, middle[1]], TEXT, TextAlign::Centre).upwards());
        canvas.text(Text::new(&self.title, [left, top - 6.0], TEXT, TextAlign::Left).bold());
    }

    /// A line through data points.
    pub(crate) fn line(
        &self,
        canvas: &mut Canvas,
        points: &[[f64; 2]],
        colour: Colour,
        dash: Dash,
        width: f64,
    ) {
        let places: Vec<CanvasPoint> =
            points.iter().map(|point| self.at(point[0], point[1])).collect();
        canvas.line(&places, width, colour, dash);
    }

    /// A band of one standard deviation around means (x, mean, standard deviation); drawn before
    /// all lines.
    pub(crate) fn band(&self, canvas: &mut Canvas, points: &[[f64; 3]], look: Look) {
        let banded: Vec<&[f64; 3]> = points.iter().filter(|point| point[2].is_finite()).collect();
        let upper = banded.iter().map(|[x, mean, sd]| self.at(*x, (mean + sd).min(self.y.high)));
        let lower =
            banded.iter().rev().map(|[x, mean, sd]| self.at(*x, (mean - sd).max(self.y.low)));
        canvas.area(upper.chain(lower).collect(), look.colour, BAND);
    }

    /// A line through means (x, mean, standard deviation) with markers on them.
    pub(crate) fn series(&self, canvas: &mut Canvas, points: &[[f64; 3]], look: Look) {
        let line: Vec<[f64; 2]> = points.iter().map(|[x, mean, _]| [*x, *mean]).collect();
        self.marked(canvas, &line, look, [LINE, MARKER]);
    }

    /// A line through data points with markers on them; `width` of the line and of the markers.
    pub(crate) fn marked(
        &self,
        canvas: &mut Canvas,
        points: &[[f64; 2]],
        look: Look,
        width: [f64; 2],
    ) {
        self.line(canvas, points, look.colour, look.dash, width[0]);
        for &[x, y] in points {
            canvas.marker(self.at(x, y), look.marker, width[1], look.colour, false);
        }
    }

    /// A vertical bar between two values, with caps.
    pub(crate) fn interval(
        &self,
        canvas: &mut Canvas,
        x: f64,
        [low, high]: [f64; 2],
        colour: Colour,
    ) {
        let [bottom, top] = [self.at(x, low), self.at(x, high)];
        canvas.line(&[bottom, top], 1.1, colour, &[]);
        for end in [bottom, top] {
            canvas.line(&[[end[0] - 2.6, end[1]], [end[0] + 2.6, end[1]]], 1.1, colour, &[]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|(_, label)| label.as_str()).collect()
    }

    #[test]
    fn ticks_are_round_and_cover_the_data() {
        let axis = Axis::covering("x", [0.3, 37.2, f64::NAN].into_iter(), 4);
        assert_eq!(labels(&axis), ["0", "10", "20", "30", "40"]);
        assert_eq!((axis.low, axis.high), (0.0, 40.0));
        assert_eq!(
            labels(&Axis::covering("x", [-0.06, 0.0].into_iter(), 3)),
            ["−0.06", "−0.04", "−0.02", "0.00"]
        );
        assert_eq!(
            labels(&Axis::exact("x", 0.0, 1.0, 4)),
            ["0.00", "0.25", "0.50", "0.75", "1.00"]
        );
        assert_eq!(labels(&Axis::exact("x", 3.0, 11.0, 3)), ["5", "10"]);
    }

    #[test]
    fn logarithms_have_round_ends_and_as_many_ticks_as_fit() {
        let axis = Axis::log("x", [0.9, 31.0].into_iter(), 200.0);
        assert_eq!(labels(&axis), ["0.5", "1", "2", "5", "10", "20", "50"]);
        let axis = Axis::log("x", [0.9, 31.0].into_iter(), 80.0);
        assert_eq!(labels(&axis), ["1", "10"]);
        let axis = Axis::sizes("x", &[0, 500, 10_000]);
        assert_eq!(labels(&axis), ["0", "500", "10,000"]);
        assert!(axis.low < 500f64.log10() && axis.high > 4.0);
    }

    #[test]
    fn one_value_still_has_an_axis() {
        let axis = Axis::covering("x", [5.0, 5.0].into_iter(), 3);
        assert!(axis.low < 5.0 && axis.high > 5.0);
        let axis = Axis::covering("x", std::iter::empty(), 3);
        assert!(axis.low < axis.high);
    }
}
