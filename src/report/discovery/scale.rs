//! Sizes over the noise floor as colours: six steps, lighter to darker, so that a grey print keeps
//! their order. The page turns the same six round for dark screens.

use super::super::style::{Colour, GREY, INK, SMALL, WHITE};
use crate::data::findings::{Findings, Verdict};
use crate::report::drawing::{Canvas, CanvasPoint, Text, TextAlign, text_width};

/// Upper end of each step, as a multiple of the noise floor, its colour, and the colour of a number
/// on it.
const STEPS: [(f64, Colour, Colour); 6] = [
    (1.2, [238, 238, 238], INK),
    (2.0, [254, 217, 142], INK),
    (4.0, [254, 153, 41], INK),
    (8.0, [217, 95, 14], INK),
    (16.0, [153, 52, 4], WHITE),
    (f64::INFINITY, [84, 20, 0], WHITE),
];

/// Corrected probability under which a place is marked as more than noise: that of the tests
/// (`false_alarm` of the options by default).
pub const SIGNIFICANCE_LEVEL: f64 = 0.001;

/// Whether places are marked before and after: not where the tests find no more than noise.
pub(super) fn marked(findings: &Findings) -> [bool; 2] {
    [findings.verdict != Verdict::Consistent, !findings.complete]
}

/// The step of a ratio; none where it is not a number.
fn step(ratio: f64) -> Option<&'static (f64, Colour, Colour)> {
    STEPS.iter().find(|(end, _, _)| ratio <= *end)
}

/// Colour of a cell and of what is written on it.
pub(super) fn cell(ratio: f64) -> (Colour, Colour) {
    step(ratio).map_or((WHITE, GREY), |(_, colour, ink)| (*colour, *ink))
}

/// Colour of a mark on white: what is no more than noise stands back.
pub(super) fn mark(ratio: f64) -> Colour {
    if ratio <= STEPS[0].0 { [170, 170, 170] } else { cell(ratio).0 }
}

/// The six steps with their ends, in a row whose text has its baseline at `at`; wraps before
/// `right`. Returns the last baseline.
pub(super) fn key(canvas: &mut Canvas, at: CanvasPoint, right: f64, heading: &str) -> f64 {
    canvas.text(Text::new(heading, at, SMALL, TextAlign::Left));
    let [mut x, mut y] = [at[0] + text_width(heading, SMALL, false) + 10.0, at[1]];
    for (index, (end, colour, _)) in STEPS.iter().enumerate() {
        let low = if index == 0 { 0.0 } else { STEPS[index - 1].0 };
        let label = match index {
            0 => format!("up to {end}"),
            _ if end.is_infinite() => format!("over {low}"),
            _ => format!("{low}–{end}"),
        };
        let wide = 18.0 + text_width(&label, SMALL, false);
        if x + wide > right {
            x = at[0];
            y += 16.0;
        }
        canvas.rectangle([x, y - 9.0], [x + 13.0, y + 2.0], *colour, 1.0);
        canvas.text(Text::new(label, [x + 18.0, y], SMALL, TextAlign::Left));
        x += wide + 12.0;
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_grow_darker_and_numbers_on_them_are_read() {
        let light = |colour: Colour| {
            let part = |index: usize| {
                let value = f64::from(colour[index]) / 255.0;
                if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
            };
            0.2126 * part(0) + 0.7152 * part(1) + 0.0722 * part(2)
        };
        assert!(STEPS.windows(2).all(|pair| light(pair[0].1) > light(pair[1].1) + 0.02));
        for (_, colour, ink) in STEPS {
            let (a, b) = (light(colour).max(light(ink)), light(colour).min(light(ink)));
            // Contrast of the web's accessibility guidelines (WCAG 2.1, 1.4.3: large or bold text
            // 3, others 4.5).
            assert!((a + 0.05) / (b + 0.05) > 3.9, "{colour:?}");
        }
        assert_eq!(cell(f64::NAN), (WHITE, GREY));
        assert_eq!(cell(1e9).0, STEPS[5].1);
    }
}
