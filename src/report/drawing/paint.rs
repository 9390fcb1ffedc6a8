//! Primitives to bytes: PNG with two pixels per hundredth of an inch, and SVG. The font is embedded
//! in the program, so the same primitives give the same bytes on every machine.

use std::sync::OnceLock;

use plotters::backend::{BitMapBackend, DrawingBackend, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{
    Color, FontDesc, FontFamily, FontStyle, FontTransform, RGBAColor, RGBColor, ShapeStyle,
    TextStyle, register_font,
};

use super::canvas::{Canvas, CanvasPoint, Primitive, Text, TextAlign};
use crate::report::style::Colour;

/// The embedded font's name, followed in SVG by fonts of similar widths.
const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";
/// Pixels of the PNG per hundredth of an inch.
const PIXELS: usize = 2;
/// Each pixel is the mean of this many samples squared, for smooth edges.
const SAMPLES: usize = 3;
/// Units of the SVG's grid per hundredth of an inch (its coordinates are integers).
const SVG_UNITS: f64 = 10.0;
/// Ascent plus descent of the font, in ems.
const FONT_HEIGHT: f64 = 1.164;
/// The SVG backend divides a size by this to get the em.
const SVG_FONT: f64 = 1.24;
/// Distance of the baseline below the anchor in the bitmap backend, in font heights.
const BITMAP_BASELINE: f64 = 0.5;
/// Distance of the baseline below the anchor in the SVG backend, in ems.
const SVG_BASELINE: f64 = 0.76;

/// Why a figure could not be painted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub(crate) struct PaintError(String);

fn failed(error: impl std::fmt::Display) -> PaintError {
    PaintError(error.to_string())
}

/// The PNG of a figure.
pub(crate) fn png(canvas: &Canvas) -> Result<Vec<u8>, PaintError> {
    let (pixels, wide, high) = pixels(canvas, PIXELS)?;
    encode(&pixels, wide, high)
}

/// The pixels of a figure, three bytes each, and their number across and down; `density` to the
/// hundredth of an inch.
pub(crate) fn pixels(
    canvas: &Canvas,
    density: usize,
) -> Result<(Vec<u8>, usize, usize), PaintError> {
    register()?;
    let scale = (density * SAMPLES) as f64;
    let (wide, high) = ((canvas.width as usize) * density, (canvas.height as usize) * density);
    let mut fine = vec![255u8; wide * SAMPLES * high * SAMPLES * 3];
    {
        let size = ((wide * SAMPLES) as u32, (high * SAMPLES) as u32);
        let mut backend = BitMapBackend::with_buffer(&mut fine, size);
        let mut painter = Painter { backend: &mut backend, scale, bitmap: true };
        canvas.marks.iter().try_for_each(|mark| painter.paint(mark))?;
        backend.present().map_err(failed)?;
    }
    Ok((shrink(&fine, wide), wide, high))
}

/// The SVG of a figure, as a page shows it: a pixel per hundredth of an inch.
pub(crate) fn svg(canvas: &Canvas) -> Result<Vec<u8>, PaintError> {
    sized_svg(canvas, |length| length.to_string())
}

/// The SVG of a figure with its size in millimetres, as it is printed.
pub(crate) fn printed_svg(canvas: &Canvas) -> Result<Vec<u8>, PaintError> {
    sized_svg(canvas, |length| format!("{:.1}mm", 0.254 * length))
}

fn sized_svg(canvas: &Canvas, size: impl Fn(f64) -> String) -> Result<Vec<u8>, PaintError> {
    register()?;
    let mut text = String::new();
    let (wide, high) = ((canvas.width * SVG_UNITS) as u32, (canvas.height * SVG_UNITS) as u32);
    {
        let mut backend = SVGBackend::with_string(&mut text, (wide, high));
        let mut painter = Painter { backend: &mut backend, scale: SVG_UNITS, bitmap: false };
        let corners =
            [[0.0, 0.0], [canvas.width, 0.0], [canvas.width, canvas.height], [0.0, canvas.height]];
        painter.area(&corners, crate::report::style::WHITE, 1.0)?;
        canvas.marks.iter().try_for_each(|mark| painter.paint(mark))?;
        backend.present().map_err(failed)?;
    }
    let grid = format!("width=\"{wide}\" height=\"{high}\"");
    let [width, height] = [canvas.width, canvas.height].map(size);
    let size = format!("width=\"{width}\" height=\"{height}\"");
    Ok(text.replacen(&grid, &size, 1).into_bytes())
}

/// Width of a text, hundredths of an inch.
pub(crate) fn text_width(text: &str, size: f64, bold: bool) -> f64 {
    const FINE: f64 = 20.0;
    if register().is_err() {
        return 0.0;
    }
    font(size * FONT_HEIGHT * FINE, bold)
        .layout_box(text)
        .map_or(0.0, |((left, _), (right, _))| f64::from(right - left) / FINE)
}

/// Registers the embedded fonts, once.
fn register() -> Result<(), PaintError> {
    static DONE: OnceLock<bool> = OnceLock::new();
    let done = DONE.get_or_init(|| {
        register_font(FAMILY, FontStyle::Normal, dejavu::sans::regular()).is_ok()
            && register_font(FAMILY, FontStyle::Bold, dejavu::sans::bold()).is_ok()
    });
    if *done { Ok(()) } else { Err(PaintError("the embedded font cannot be read".to_owned())) }
}

/// The embedded font in a weight; a loaded font keeps the weight with which it was loaded.
fn font(size: f64, bold: bool) -> FontDesc<'static> {
    FontDesc::new(
        FontFamily::Name(FAMILY),
        size,
        if bold { FontStyle::Bold } else { FontStyle::Normal },
    )
}

/// Paints primitives on one of the two backends.
struct Painter<'a, B> {
    backend: &'a mut B,
    scale: f64,
    bitmap: bool,
}

impl<B: DrawingBackend> Painter<'_, B> {
    fn paint(&mut self, mark: &Primitive) -> Result<(), PaintError> {
        match mark {
            Primitive::Stroke { points, width, colour } => self.stroke(points, *width, *colour),
            Primitive::Area { points, colour, opacity } => self.area(points, *colour, *opacity),
            Primitive::Disc { centre, radius, colour, opacity } => {
                self.disc(*centre, *radius, *colour, *opacity)
            }
            Primitive::Text(text) => self.text(text),
        }
    }

    fn grid(&self, [x, y]: CanvasPoint) -> (i32, i32) {
        ((x * self.scale).round() as i32, (y * self.scale).round() as i32)
    }

    /// On the bitmap each segment is a quadrilateral and each joint a disc, as the backend's thick
    /// lines have gaps at sharp turns.
    fn stroke(
        &mut self,
        points: &[CanvasPoint],
        width: f64,
        colour: Colour,
    ) -> Result<(), PaintError> {
        if !self.bitmap {
            let style = style(colour, 1.0).stroke_width((width * self.scale).round() as u32);
            let path: Vec<(i32, i32)> = points.iter().map(|&point| self.grid(point)).collect();
            return self.backend.draw_path(path, &style).map_err(failed);
        }
        for pair in points.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            let length = (to[0] - from[0]).hypot(to[1] - from[1]);
            if length < 1e-9 {
                continue;
            }
            let side = [
                0.5 * width * (to[1] - from[1]) / length,
                0.5 * width * (from[0] - to[0]) / length,
            ];
            let off = |point: CanvasPoint, sign: f64| {
                [point[0] + sign * side[0], point[1] + sign * side[1]]
            };
            self.area(
                &[off(from, 1.0), off(to, 1.0), off(to, -1.0), off(from, -1.0)],
                colour,
                1.0,
            )?;
        }
        let joints = points.get(1..points.len().saturating_sub(1)).unwrap_or_default();
        joints.iter().try_for_each(|&joint| self.disc(joint, 0.5 * width, colour, 1.0))
    }

    fn area(
        &mut self,
        points: &[CanvasPoint],
        colour: Colour,
        opacity: f64,
    ) -> Result<(), PaintError> {
        if points.len() < 3 {
            return Ok(());
        }
        let points: Vec<(i32, i32)> = points.iter().map(|&point| self.grid(point)).collect();
        self.backend.fill_polygon(points, &style(colour, opacity).filled()).map_err(failed)
    }

    fn disc(
        &mut self,
        centre: CanvasPoint,
        radius: f64,
        colour: Colour,
        opacity: f64,
    ) -> Result<(), PaintError> {
        let centre = self.grid(centre);
        let radius = (radius * self.scale).round().max(1.0) as u32;
        self.backend
            .draw_circle(centre, radius, &style(colour, opacity).filled(), true)
            .map_err(failed)
    }

    fn text(&mut self, text: &Text) -> Result<(), PaintError> {
        let em = text.size * self.scale;
        let (size, drop) = if self.bitmap {
            (em * FONT_HEIGHT, em * FONT_HEIGHT * BITMAP_BASELINE)
        } else {
            (em * SVG_FONT, em * SVG_BASELINE)
        };
        let horizontal = match text.align {
            TextAlign::Left => HPos::Left,
            TextAlign::Centre => HPos::Center,
            TextAlign::Right => HPos::Right,
        };
        let font = font(size, text.bold);
        let font = if text.upwards { font.transform(FontTransform::Rotate270) } else { font };
        let ink = colour(text.colour);
        let style = TextStyle::from(font).color(&ink).pos(Pos::new(horizontal, VPos::Top));
        let (x, y) = self.grid(text.at);
        let drop = drop.round() as i32;
        let anchor = if text.upwards { (x - drop, y) } else { (x, y - drop) };
        self.backend.draw_text(&text.text, &style, anchor).map_err(failed)
    }
}

fn colour([red, green, blue]: Colour) -> RGBColor {
    RGBColor(red, green, blue)
}

fn style(from: Colour, opacity: f64) -> ShapeStyle {
    let mixed: RGBAColor = colour(from).mix(opacity);
    ShapeStyle::from(mixed)
}

/// Means over squares of samples.
fn shrink(fine: &[u8], wide: usize) -> Vec<u8> {
    const SQUARE: usize = SAMPLES * SAMPLES;
    let line = wide * SAMPLES * 3;
    let row_of_pixels = |samples: &[u8]| {
        let mut sums = vec![0; wide * 3];
        for line in samples.chunks_exact(line) {
            for (pixel, samples) in sums.chunks_exact_mut(3).zip(line.chunks_exact(3 * SAMPLES)) {
                for sample in samples.chunks_exact(3) {
                    for channel in 0..3 {
                        pixel[channel] += usize::from(sample[channel]);
                    }
                }
            }
        }
        sums.into_iter().map(|sum| ((sum + SQUARE / 2) / SQUARE) as u8)
    };
    fine.chunks_exact(SAMPLES * line).flat_map(row_of_pixels).collect()
}

fn encode(pixels: &[u8], wide: usize, high: usize) -> Result<Vec<u8>, PaintError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, wide as u32, high as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Default);
    encoder.set_adaptive_filter(png::AdaptiveFilterType::Adaptive);
    // Two pixels per hundredth of an inch: 200 dpi, 7874 per metre.
    encoder.set_pixel_dims(Some(png::PixelDimensions {
        xppu: 7874,
        yppu: 7874,
        unit: png::Unit::Meter,
    }));
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(pixels).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(bytes)
}
