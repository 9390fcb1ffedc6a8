//! Isometric view of points in space, with a triad of axes and a scale bar.

use super::canvas::{Canvas, CanvasPoint, Text, TextAlign};
use crate::base::Point3;
use crate::report::style::{HAIR, HALF_CAP, INK, SMALL};

/// Isometric view: x (up, against gravity) upwards, z (along the robot) to the lower right, y to
/// the lower left. Screen coordinates to the right and **up**, in the units of the points.
pub(crate) fn isometric([x, y, z]: Point3) -> [f64; 2] {
    let (sin, cos) = (0.5, 0.75f64.sqrt());
    [(z - y) * cos, x - (z + y) * sin]
}

/// A view of the isometric plane: the visible part and its frame on the figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct View {
    corner: CanvasPoint,
    size: [f64; 2],
    /// Centre of the visible part.
    centre: [f64; 2],
    /// Hundredths of an inch to a metre.
    scale: f64,
}

impl View {
    /// A view in a frame that shows all `points` with a margin of `margin` inside the frame.
    pub(crate) fn of(
        points: impl Iterator<Item = Point3>,
        corner: CanvasPoint,
        size: [f64; 2],
        margin: f64,
    ) -> View {
        let start = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let flat = points.map(isometric).filter(|place| place.iter().all(|part| part.is_finite()));
        let (low, high) = flat.fold(start, |(low, high), [u, v]| {
            ([low[0].min(u), low[1].min(v)], [high[0].max(u), high[1].max(v)])
        });
        let span = |axis: usize| (high[axis] - low[axis]).max(1e-6);
        let scale = ((size[0] - 2.0 * margin) / span(0)).min((size[1] - 2.0 * margin) / span(1));
        let centre = [(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0];
        View { corner, size, centre, scale }
    }

    /// The same part of the plane in another frame, scaled to fit.
    pub(crate) fn moved(&self, corner: CanvasPoint, size: [f64; 2]) -> View {
        let shrink = (size[0] / self.size[0]).min(size[1] / self.size[1]);
        View { corner, size, centre: self.centre, scale: self.scale * shrink }
    }

    /// Position of a point of space on the figure.
    pub(crate) fn at(&self, point: Point3) -> CanvasPoint {
        let [u, v] = isometric(point);
        let middle = [self.corner[0] + self.size[0] / 2.0, self.corner[1] + self.size[1] / 2.0];
        [
            middle[0] + self.scale * (u - self.centre[0]),
            middle[1] - self.scale * (v - self.centre[1]),
        ]
    }

    /// Draws the three axes as arrows of `length` from a point on the figure.
    pub(crate) fn triad(&self, canvas: &mut Canvas, at: CanvasPoint, length: f64) {
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let mut direction = [0.0; 3];
            direction[axis] = 1.0;
            self.arrow(canvas, at, direction, length, name);
        }
    }

    /// Draws a direction as a named arrow.
    pub(crate) fn arrow(
        &self,
        canvas: &mut Canvas,
        at: CanvasPoint,
        direction: Point3,
        length: f64,
        name: &str,
    ) {
        let [u, v] = isometric(direction);
        let tip = [at[0] + length * u, at[1] - length * v];
        canvas.line(&[at, tip], 1.1, INK, &[]);
        let side = [-v * 2.4, -u * 2.4];
        let back = [tip[0] - 6.0 * u, tip[1] + 6.0 * v];
        let barbs = vec![
            tip,
            [back[0] + side[0], back[1] + side[1]],
            [back[0] - side[0], back[1] - side[1]],
        ];
        canvas.area(barbs, INK, 1.0);
        let label = [tip[0] + 9.0 * u, tip[1] - 9.0 * v + HALF_CAP * SMALL];
        canvas.text(Text::new(name, label, SMALL, TextAlign::Centre));
    }

    /// Length on the figure of a length across the line of sight.
    pub(crate) fn length(&self, length_m: f64) -> f64 {
        // The axes are drawn at full length, so that all else is longer by this.
        self.scale * length_m * 1.5f64.sqrt()
    }

    /// Draws a scale bar of `length_m` with its label, with its left end at a point on the figure.
    /// It holds for lengths along the axes.
    pub(crate) fn scale_bar(&self, canvas: &mut Canvas, at: CanvasPoint, length_m: f64) {
        let end = [at[0] + self.scale * length_m, at[1]];
        canvas.line(&[at, end], 1.6, INK, &[]);
        for place in [at, end] {
            canvas.line(&[[place[0], place[1] - 3.0], [place[0], place[1] + 3.0]], HAIR, INK, &[]);
        }
        let middle = [(at[0] + end[0]) / 2.0, at[1] - 5.0];
        canvas.text(Text::new(
            format!("{:.0} mm", 1e3 * length_m),
            middle,
            SMALL,
            TextAlign::Centre,
        ));
    }
}
