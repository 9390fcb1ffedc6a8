//! How a data series is named and drawn. Registry entries state it, tables and figures read it.

/// A colour: red, green and blue.
pub type Colour = [u8; 3];

/// The shape of a marker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// A filled circle.
    Circle,
    /// A filled square.
    Square,
    /// A filled diamond.
    Diamond,
    /// A filled triangle, point up.
    Triangle,
}

/// Lengths of stroke and gap in turn; empty for an unbroken line.
pub type Dash = &'static [f64];

/// An unbroken line.
pub const SOLID: Dash = &[];
/// Long strokes.
pub const DASHED: Dash = &[6.0, 3.0];
/// Dots.
pub const DOTTED: Dash = &[1.6, 2.4];
/// A stroke and a dot.
pub const DASH_DOT: Dash = &[6.0, 2.4, 1.6, 2.4];

/// How a series looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Colour of line, marker and band.
    pub colour: Colour,
    /// Marker.
    pub marker: Marker,
    /// Dash of the line.
    pub dash: Dash,
}

/// Colours of Okabe & Ito (2008) in the order in which series take them. They are told apart with
/// every common colour vision.
pub const PALETTE: [Colour; 6] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [230, 159, 0], [86, 180, 233]];

const MARKERS: [Marker; 6] = [
    Marker::Circle,
    Marker::Square,
    Marker::Diamond,
    Marker::Triangle,
    Marker::Circle,
    Marker::Square,
];
const DASHES: [Dash; 6] = [SOLID, DASHED, DASH_DOT, DOTTED, DASHED, SOLID];

impl Look {
    /// The look of series number `index`. The first 24 differ in colour or in the pair of marker
    /// and dash.
    pub const fn assigned(index: usize) -> Look {
        let round = index / PALETTE.len();
        Look {
            colour: PALETTE[index % PALETTE.len()],
            marker: MARKERS[(index + round) % MARKERS.len()],
            dash: DASHES[(index + 2 * round) % DASHES.len()],
        }
    }
}

/// The name of a series as it is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SeriesLabel {
    /// In figures.
    pub plain: &'static str,
    /// In Markdown.
    pub markdown: &'static str,
    /// In LaTeX.
    pub latex: &'static str,
}

impl SeriesLabel {
    /// A label that is the same text everywhere; it holds no character that Markdown or LaTeX reads
    /// as markup.
    pub const fn text(text: &'static str) -> SeriesLabel {
        SeriesLabel { plain: text, markdown: text, latex: text }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn assigned_looks_differ() {
        let looks: Vec<Look> = (0..24).map(Look::assigned).collect();
        for (index, look) in looks.iter().enumerate() {
            assert!(!looks[..index].contains(look), "look {index} is that of an earlier series");
        }
    }
}
