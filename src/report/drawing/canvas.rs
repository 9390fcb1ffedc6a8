//! A figure as a list of primitives, from which both PNG and SVG are painted.

use crate::report::style::{Colour, Dash, Marker, WHITE};

/// A point on the figure: right and down from the upper left corner, hundredths of an inch.
pub(crate) type CanvasPoint = [f64; 2];

/// Position of the anchor along a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TextAlign {
    Left,
    Centre,
    Right,
}

/// A line of text whose baseline passes through `at`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Text {
    pub(crate) at: CanvasPoint,
    pub(crate) text: String,
    /// Size of the em.
    pub(crate) size: f64,
    pub(crate) bold: bool,
    pub(crate) colour: Colour,
    pub(crate) align: TextAlign,
    /// Rotated to read upwards.
    pub(crate) upwards: bool,
}

/// One primitive.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Primitive {
    Stroke { points: Vec<CanvasPoint>, width: f64, colour: Colour },
    Area { points: Vec<CanvasPoint>, colour: Colour, opacity: f64 },
    Disc { centre: CanvasPoint, radius: f64, colour: Colour, opacity: f64 },
    Text(Text),
}

/// The primitives of a figure in the order of painting.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Canvas {
    pub(crate) width: f64,
    pub(crate) height: f64,
    pub(crate) marks: Vec<Primitive>,
}

impl Canvas {
    pub(crate) fn new(width: f64, height: f64) -> Self {
        Canvas { width, height, marks: Vec::new() }
    }

    /// The finite points; those far outside the figure are moved close to its edge, which bounds
    /// the cost of painting.
    fn drawable(&self, points: &[CanvasPoint]) -> Vec<CanvasPoint> {
        let seen = points.iter().filter(|point| !point[0].is_nan() && !point[1].is_nan());
        seen.map(|[x, y]| [x.clamp(-50.0, self.width + 50.0), y.clamp(-50.0, self.height + 50.0)])
            .collect()
    }

    /// A line through the points.
    pub(crate) fn line(&mut self, points: &[CanvasPoint], width: f64, colour: Colour, dash: Dash) {
        for points in dashes(&self.drawable(points), dash) {
            self.marks.push(Primitive::Stroke { points, width, colour });
        }
    }

    /// A filled polygon.
    pub(crate) fn area(&mut self, points: Vec<CanvasPoint>, colour: Colour, opacity: f64) {
        let points = self.drawable(&points);
        self.marks.push(Primitive::Area { points, colour, opacity });
    }

    /// A filled rectangle between two corners.
    pub(crate) fn rectangle(
        &mut self,
        [x0, y0]: CanvasPoint,
        [x1, y1]: CanvasPoint,
        colour: Colour,
        opacity: f64,
    ) {
        self.area(vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]], colour, opacity);
    }

    /// A filled circle.
    pub(crate) fn disc(&mut self, centre: CanvasPoint, radius: f64, colour: Colour, opacity: f64) {
        for centre in self.drawable(&[centre]) {
            self.marks.push(Primitive::Disc { centre, radius, colour, opacity });
        }
    }

    /// A marker with a thin white rim that separates neighbours; hollow where `hollow`.
    pub(crate) fn marker(
        &mut self,
        at: CanvasPoint,
        shape: Marker,
        radius: f64,
        colour: Colour,
        hollow: bool,
    ) {
        self.shape(at, shape, radius + 0.8, WHITE);
        self.shape(at, shape, radius, colour);
        if hollow {
            self.shape(at, shape, radius - 1.2, WHITE);
        }
    }

    fn shape(&mut self, at: CanvasPoint, shape: Marker, radius: f64, colour: Colour) {
        let corners: &[CanvasPoint] = match shape {
            Marker::Circle => return self.disc(at, radius, colour, 1.0),
            Marker::Square => &[[-0.89, -0.89], [0.89, -0.89], [0.89, 0.89], [-0.89, 0.89]],
            Marker::Diamond => &[[0.0, -1.25], [1.25, 0.0], [0.0, 1.25], [-1.25, 0.0]],
            Marker::Triangle => &[[0.0, -1.25], [1.12, 0.85], [-1.12, 0.85]],
        };
        let points =
            corners.iter().map(|corner| [at[0] + radius * corner[0], at[1] + radius * corner[1]]);
        self.area(points.collect(), colour, 1.0);
    }

    /// A line of text.
    pub(crate) fn text(&mut self, text: Text) {
        self.marks.push(Primitive::Text(text));
    }
}

impl Text {
    /// Upright text in ink.
    pub(crate) fn new(
        text: impl Into<String>,
        at: CanvasPoint,
        size: f64,
        align: TextAlign,
    ) -> Self {
        let colour = crate::report::style::INK;
        Text { at, text: text.into(), size, bold: false, colour, align, upwards: false }
    }

    pub(crate) fn bold(self) -> Self {
        Text { bold: true, ..self }
    }

    pub(crate) fn upwards(self) -> Self {
        Text { upwards: true, ..self }
    }

    pub(crate) fn colour(self, colour: Colour) -> Self {
        Text { colour, ..self }
    }
}

/// A line cut into its dashes.
fn dashes(points: &[CanvasPoint], dash: Dash) -> Vec<Vec<CanvasPoint>> {
    if dash.is_empty() {
        return vec![points.to_vec()];
    }
    let mut pieces = Vec::new();
    let mut piece: Vec<CanvasPoint> = points.first().copied().into_iter().collect();
    let (mut dash_index, mut remaining) = (0, dash[0]);
    for pair in points.windows(2) {
        let mut from = pair[0];
        let mut length = (pair[1][0] - from[0]).hypot(pair[1][1] - from[1]);
        while length > remaining {
            let share = remaining / length;
            from = [
                from[0] + share * (pair[1][0] - from[0]),
                from[1] + share * (pair[1][1] - from[1]),
            ];
            length -= remaining;
            // Even lengths are drawn, odd ones are gaps.
            if dash_index % 2 == 0 {
                piece.push(from);
                pieces.push(std::mem::take(&mut piece));
            } else {
                piece = vec![from];
            }
            dash_index += 1;
            remaining = dash[dash_index % dash.len()];
        }
        remaining -= length;
        if dash_index % 2 == 0 {
            piece.push(pair[1]);
        }
    }
    pieces.extend((piece.len() > 1).then_some(piece));
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_cover_their_share_of_a_bent_line() {
        let line = [[0.0, 0.0], [7.0, 0.0], [7.0, 20.0]];
        let pieces = dashes(&line, &[6.0, 3.0]);
        let length = |piece: &Vec<CanvasPoint>| -> f64 {
            piece.windows(2).map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1])).sum()
        };
        assert_eq!(pieces.iter().map(length).sum::<f64>(), 18.0);
        assert_eq!(pieces[1], [[7.0, 2.0], [7.0, 8.0]]);
        assert_eq!(dashes(&line, &[]).len(), 1);
    }
}
