//! A small picture of an effect: what the nominal robot does, and what the robot with the effect
//! does under the same commands.

use super::drawing::{Axis, Canvas, LegendEntry, Panel, legend, range, svg};
use super::style::{BLUE, GREY, LEFT_MARGIN, LINE, MARKER, Marker, SOLID, TALL, VERMILION};
use super::{Artifact, OutputFolder, ReportError};

/// Width of the picture, hundredths of an inch, and height of its panel.
const WIDTH: f64 = 330.0;
const HEIGHT: f64 = 130.0;

/// What a curve shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EffectView {
    /// The body at rest from base to tip, in the plane of z and this axis (0: x, 1: y), metres.
    Shape(usize),
    /// The tip along x over time, s and metres.
    Response,
    /// The tip along x over the pull of the first tendon, metres.
    Loop,
}

/// The curve of one robot.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectCurve {
    /// Its points, in seconds and metres.
    pub points: Vec<[f64; 2]>,
    /// The measured tip of a shape.
    pub tip: Option<[f64; 2]>,
}

/// A picture of an effect.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectPicture {
    /// Name of the effect.
    pub name: &'static str,
    /// Its parameters and their values, in words.
    pub parameters: String,
    /// What the curves show.
    pub view: EffectView,
    /// The robot without the effect.
    pub nominal: EffectCurve,
    /// The robot with it.
    pub with_effect: EffectCurve,
}

impl EffectPicture {
    /// The picture as `NAME.svg` and its caption as `NAME.md`.
    ///
    /// # Errors
    /// [`ReportError::Draw`] when it cannot be painted.
    pub fn files(&self) -> Result<[Artifact; 2], ReportError> {
        let failed = |error: super::drawing::PaintError| ReportError::Draw {
            figure: "effects",
            reason: error.to_string(),
        };
        let file = |end: &str, bytes| Artifact {
            name: format!("{}.{end}", self.name),
            folder: OutputFolder::Plots,
            bytes,
        };
        let picture = svg(&self.draw()).map_err(failed)?;
        Ok([file("svg", picture), file("md", format!("{}\n", self.caption()).into_bytes())])
    }

    fn caption(&self) -> String {
        let what = match self.view {
            EffectView::Shape(_) => {
                "Shape at rest under one command and measured tip (mark), seen from the side, in mm"
            }
            EffectView::Response => "Tip against time after one command, in mm and s",
            EffectView::Loop => "Tip against the pull of the first tendon, there and back, in mm",
        };
        format!("{what}: the nominal robot and the robot with {}.", self.parameters)
    }

    /// Factors from the units of the points to those of the axes, and the labels of these.
    fn axes(&self) -> ([f64; 2], [&'static str; 2]) {
        match self.view {
            EffectView::Shape(0) => ([1e3, 1e3], ["z (mm)", "x (mm)"]),
            EffectView::Shape(_) => ([1e3, 1e3], ["z (mm)", "y (mm)"]),
            EffectView::Response => ([1.0, 1e3], ["time (s)", "tip, x (mm)"]),
            EffectView::Loop => ([1e3, 1e3], ["pull (mm)", "tip, x (mm)"]),
        }
    }

    fn draw(&self) -> Canvas {
        let mut canvas = Canvas::new(WIDTH, TALL);
        let keys = [
            (LegendEntry::Line(GREY, SOLID), "nominal"),
            (LegendEntry::Line(BLUE, SOLID), self.parameters.as_str()),
        ];
        let top = legend(&mut canvas, [10.0, 16.0], WIDTH - 6.0, &keys) + 12.0;
        let (factors, labels) = self.axes();
        let scaled = |point: &[f64; 2]| [factors[0] * point[0], factors[1] * point[1]];
        let all = |part: usize| {
            let curves = [&self.nominal, &self.with_effect];
            curves.into_iter().flat_map(move |curve| {
                curve.points.iter().chain(&curve.tip).map(move |point| scaled(point)[part])
            })
        };
        let room = WIDTH - LEFT_MARGIN - 14.0;
        let mut size = [room, HEIGHT];
        let axes = [0, 1].map(|part| Axis::covering(labels[part], all(part), 4));
        let [x, mut y] = axes;
        if matches!(self.view, EffectView::Shape(_)) {
            // One scale for both directions.
            let scale = room / (x.high - x.low);
            let (low, high) = range(all(1));
            let half = (0.55 * (high - low)).max(0.35 * HEIGHT / scale);
            let middle = 0.5 * (low + high);
            y = Axis::exact(labels[1], middle - half, middle + half, 4);
            size[1] = scale * (y.high - y.low);
        }
        let panel =
            canvas.panel(Panel { corner: [LEFT_MARGIN, top], size, x, y, title: String::new() });
        for (curve, colour, width) in
            [(&self.nominal, GREY, LINE), (&self.with_effect, BLUE, 1.2 * LINE)]
        {
            let points: Vec<[f64; 2]> = curve.points.iter().map(scaled).collect();
            panel.line(&mut canvas, &points, colour, SOLID, width);
            if let Some([x, y]) = curve.tip.as_ref().map(scaled) {
                let colour = if colour == BLUE { VERMILION } else { colour };
                canvas.marker(panel.at(x, y), Marker::Circle, MARKER, colour, false);
            }
        }
        canvas.height = (top + size[1] + 44.0).round();
        canvas
    }
}
