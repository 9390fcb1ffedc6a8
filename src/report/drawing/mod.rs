//! Drawing: a figure as a list of primitives, axes and legends on it, and its PNG and SVG.

mod axes;
mod canvas;
mod isometric;
mod legend;
mod paint;

pub(super) use axes::{Axis, Panel, range, signed};
pub(super) use canvas::{Canvas, CanvasPoint, Text, TextAlign};
pub(super) use isometric::View;
pub(super) use legend::{LegendEntry, legend};
pub(super) use paint::{PaintError, pixels, png, svg, text_width};
