//! Keys above the panels, so that they cover no data.

use super::canvas::{Align, Canvas, Place, Text};
use super::paint::text_width;
use super::style::{BAND, Colour, Dash, LINE, Look, MARKER, Marker, SMALL, TEXT};

/// What stands before a name in a legend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Key {
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

/// Draws keys in a row whose text has its baseline at `at` (left end), and wraps before `right`. Returns the last
/// baseline.
pub(super) fn legend(canvas: &mut Canvas, at: Place, right: f64, keys: &[(Key, &str)]) -> f64 {
    let [mut x, mut y] = at;
    for (key, name) in keys {
        let width = text_width(name, SMALL, false);
        if x > at[0] && x + KEY_WIDTH + 5.0 + width > right {
            x = at[0];
            y += TEXT + 5.0;
        }
        draw_key(canvas, *key, [x, y - 0.36 * SMALL]);
        canvas.text(Text::new(*name, [x + KEY_WIDTH + 5.0, y], SMALL, Align::Left));
        x += KEY_WIDTH + 5.0 + width + GAP;
    }
    y
}

fn draw_key(canvas: &mut Canvas, key: Key, [x, y]: Place) {
    let middle = [x + KEY_WIDTH / 2.0, y];
    let line = [[x, y], [x + KEY_WIDTH, y]];
    match key {
        Key::Series(look) | Key::Plain(look) => {
            if matches!(key, Key::Series(_)) {
                canvas.rectangle([x, y - 4.5], [x + KEY_WIDTH, y + 4.5], look.colour, BAND);
            }
            canvas.line(&line, LINE, look.colour, look.dash);
            canvas.marker(middle, look.marker, MARKER, look.colour, false);
        }
        Key::Marker(marker, colour, hollow) => canvas.marker(middle, marker, MARKER, colour, hollow),
        Key::Dot(colour) => canvas.disc(middle, 2.6, colour, 1.0),
        Key::Line(colour, dash) => canvas.line(&line, LINE, colour, dash),
    }
}
