//! Drawing: a figure as a list of primitives, axes and legends on it, and its PNG and SVG.

pub(super) mod axes;
pub(super) mod canvas;
pub(super) mod isometric;
pub(super) mod legend;
pub(super) mod paint;
