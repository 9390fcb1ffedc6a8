//! Legends above the panels, where they cover no data.

use super::canvas::{Canvas, CanvasPoint, Text, TextAlign};
use super::paint::text_width;
use crate::report::style::{BAND, Colour, Dash, HALF_CAP, LINE, Look, MARKER, Marker, SMALL, TEXT};

/// The symbol before a name in a legend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LegendEntry {
    /// Line and marker over a band.
    Series(Look),
    /// A marker, hollow or filled.
    Marker(Marker, Colour, bool),
    /// A dot of a cloud.
    Dot(Colour),
    /// A line alone.
    Line(Colour, Dash),
    /// Line and marker alone.
    Plain(Look),
}

const KEY_WIDTH: f64 = 22.0;
const GAP: f64 = 16.0;

/// Draws entries in a row whose baseline starts at `at`, and wraps before `right`. Returns the last
/// baseline.
pub(crate) fn legend(
    canvas: &mut Canvas,
    at: CanvasPoint,
    right: f64,
    keys: &[(LegendEntry, &str)],
) -> f64 {
    let [mut x, mut y] = at;
    for (key, name) in keys {
        let width = text_width(name, SMALL, false);
        if x > at[0] && x + KEY_WIDTH + 5.0 + width > right {
            x = at[0];
            y += TEXT + 5.0;
        }
        draw_key(canvas, *key, [x, y - HALF_CAP * SMALL]);
        canvas.text(Text::new(*name, [x + KEY_WIDTH + 5.0, y], SMALL, TextAlign::Left));
        x += KEY_WIDTH + 5.0 + width + GAP;
    }
    y
}

fn draw_key(canvas: &mut Canvas, key: LegendEntry, [x, y]: CanvasPoint) {
    let middle = [x + KEY_WIDTH / 2.0, y];
    let line = [[x, y], [x + KEY_WIDTH, y]];
    match key {
        LegendEntry::Series(look) | LegendEntry::Plain(look) => {
            if matches!(key, LegendEntry::Series(_)) {
                canvas.rectangle([x, y - 4.5], [x + KEY_WIDTH, y + 4.5], look.colour, BAND);
            }
            canvas.line(&line, LINE, look.colour, look.dash);
            canvas.marker(middle, look.marker, MARKER, look.colour, false);
        }
        LegendEntry::Marker(marker, colour, hollow) => {
            canvas.marker(middle, marker, MARKER, colour, hollow)
        }
        LegendEntry::Dot(colour) => canvas.disc(middle, 2.6, colour, 1.0),
        LegendEntry::Line(colour, dash) => canvas.line(&line, LINE, colour, dash),
    }
}
