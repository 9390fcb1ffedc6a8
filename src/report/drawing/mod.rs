//! Drawing: a figure as a list of primitives, axes and legends on it, and its PNG and SVG.

mod axes;
mod canvas;
mod dots;
mod ends;
mod isometric;
mod legend;
mod paint;
mod words;

pub(super) use axes::{Axis, Panel, range, signed, thousands};
pub(super) use canvas::{Canvas, CanvasPoint, Text, TextAlign};
pub(super) use dots::{Dot, DotChart, DotPanel, DotRow, MIN_PANEL};
pub(super) use ends::{LineEnd, ends_width, name_ends};
pub(super) use isometric::View;
pub(super) use legend::{LegendEntry, legend};
pub(super) use paint::{PaintError, pixels, png, printed_svg, svg, text_width};
pub(super) use words::lines;
