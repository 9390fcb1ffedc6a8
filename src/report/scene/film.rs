//! Scenes as a moving picture: a GIF that repeats.

use std::borrow::Cow;
use std::collections::HashMap;

use gif::{DisposalMethod, Encoder, Frame, Repeat};

use super::still::{MEASURED, SLACK, Sight, TAUT, TRAIL};
use crate::base::series::{DASHED, DOTTED};
use crate::data::scene::Scene;
use crate::report::ReportError;
use crate::report::drawing::{Canvas, LegendEntry, Text, TextAlign, legend, pixels};
use crate::report::style::{GREEN, GREY, Marker, SOLID};

/// Scenes side by side, seen alike.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmStrip {
    /// What they show.
    pub heading: String,
    /// The scenes.
    pub scenes: Vec<Scene>,
}

/// Width of the picture, pixels.
const WIDTH: f64 = 800.0;
/// Height of a row of scenes with its heading, pixels.
const ROW: f64 = 292.0;
/// Height of the heading of a row and of the names of its scenes, pixels.
const HEADING: f64 = 46.0;
/// Height of the key below the rows, pixels.
const KEY: f64 = 26.0;
/// Pictures per second.
const PICTURES_PER_S: f64 = 10.0;
/// Entries of the palette; the last one means "as before".
const COLOURS: usize = 255;
/// Size of headings, pixels.
const LARGE: f64 = 14.0;
/// Size of other words, pixels.
const WORDS: f64 = 12.0;

/// The GIF of rows of scenes: each row plays once in `duration_s` seconds of the picture.
///
/// # Errors
/// [`ReportError::Draw`] where a picture cannot be painted or encoded.
pub fn film(strips: &[FilmStrip], duration_s: f64) -> Result<Vec<u8>, ReportError> {
    let failed = |reason: String| ReportError::Draw { figure: "film", reason };
    let rounded = |strip: &FilmStrip| FilmStrip {
        heading: strip.heading.clone(),
        scenes: strip.scenes.iter().cloned().map(Scene::rounded).collect(),
    };
    let strips: Vec<FilmStrip> = strips.iter().map(rounded).collect();
    let count = (duration_s * PICTURES_PER_S).round().max(1.0) as usize;
    let sights: Vec<(&FilmStrip, Vec<Sight>)> =
        strips.iter().enumerate().map(|(row, strip)| (strip, sights(strip, row))).collect();
    let mut pictures = Vec::with_capacity(count);
    let mut size = (0, 0);
    for number in 0..count {
        let share = number as f64 / (count - 1).max(1) as f64;
        let (painted, wide, high) =
            pixels(&picture(&sights, share), 1).map_err(|error| failed(error.to_string()))?;
        size = (wide, high);
        pictures.push(painted);
    }
    encoded(&pictures, size).map_err(|error| failed(error.to_string()))
}

/// The frame of a scene after a share of the strip's time.
fn frame_at(strip: &FilmStrip, scene: &Scene, share: f64) -> usize {
    let end_s = strip.scenes.iter().map(Scene::duration_s).fold(0.0, f64::max);
    let past = scene.frames.partition_point(|frame| frame.time_s <= share * end_s + 1e-9);
    past.saturating_sub(1)
}

/// How each scene of a row is seen.
fn sights(strip: &FilmStrip, row: usize) -> Vec<Sight> {
    let wide = WIDTH / strip.scenes.len().max(1) as f64;
    let top = row as f64 * ROW + HEADING;
    let corner = |column: usize| [column as f64 * wide + 6.0, top];
    (0..strip.scenes.len())
        .map(|column| Sight::of(&strip.scenes, corner(column), [wide - 12.0, ROW - HEADING - 8.0]))
        .collect()
}

fn picture(rows: &[(&FilmStrip, Vec<Sight>)], share: f64) -> Canvas {
    let mut canvas = Canvas::new(WIDTH, rows.len() as f64 * ROW + KEY);
    for (row, (strip, sights)) in rows.iter().enumerate() {
        let top = row as f64 * ROW;
        let heading = Text::new(strip.heading.clone(), [12.0, top + 18.0], LARGE, TextAlign::Left);
        canvas.text(heading.bold());
        let wide = WIDTH / strip.scenes.len().max(1) as f64;
        for (column, (scene, sight)) in strip.scenes.iter().zip(sights).enumerate() {
            let left = column as f64 * wide;
            let index = frame_at(strip, scene, share);
            sight.draw(&mut canvas, scene, index);
            let name =
                Text::new(scene.name.clone(), [left + 12.0, top + 37.0], WORDS, TextAlign::Left);
            canvas.text(name.bold());
            let right = [left + wide - 14.0, top + 37.0];
            let words = Text::new(state(scene, index), right, WORDS, TextAlign::Right);
            canvas.text(words.colour(GREY));
            if column == 0 {
                sight.head(&mut canvas, [36.0, top + ROW - 40.0], [left + 56.0, top + ROW - 10.0]);
            }
        }
    }
    let top = rows.len() as f64 * ROW;
    let frames =
        || rows.iter().flat_map(|(strip, _)| &strip.scenes).flat_map(|scene| &scene.frames);
    let has_target = frames().any(|frame| frame.target_m.is_some());
    let is_measured = frames().any(|frame| !frame.measured_m.is_empty());
    let keys = [
        (true, LegendEntry::Line(TAUT, SOLID), "tendon, taut"),
        (true, LegendEntry::Line(SLACK, DASHED), "slack"),
        (true, LegendEntry::Line(TRAIL, SOLID), "path of the tip"),
        (has_target, LegendEntry::Marker(Marker::Circle, GREEN, true), "target"),
        (is_measured, LegendEntry::Marker(Marker::Diamond, MEASURED, false), "measured tip"),
        (is_measured, LegendEntry::Line(MEASURED, DOTTED), "its path"),
    ];
    let keys: Vec<(LegendEntry, &str)> =
        keys.into_iter().filter(|key| key.0).map(|(_, entry, words)| (entry, words)).collect();
    legend(&mut canvas, [12.0, top + 15.0], WIDTH, &keys);
    canvas
}

/// Time, and the distance of the tip from its target or from the measurement.
fn state(scene: &Scene, index: usize) -> String {
    let Some(frame) = scene.frames.get(index) else { return String::new() };
    let from = frame.measured_m.first().map(|place| (place, "from measured"));
    let to = frame.target_m.as_ref().map(|place| (place, "from target"));
    let distance = frame.tip_m.zip(to.or(from)).map(|(tip_m, (place, words))| {
        format!("   {:4.1} mm {words}", 1e3 * crate::base::distance_m(&tip_m, place))
    });
    format!("{:.1} s{}", frame.time_s, distance.unwrap_or_default())
}

/// Pictures of three bytes a pixel as a GIF that repeats. A picture holds only what has changed.
fn encoded(
    pictures: &[Vec<u8>],
    (wide, high): (usize, usize),
) -> Result<Vec<u8>, gif::EncodingError> {
    let mut palette = Palette::of(pictures);
    let mut bytes = Vec::new();
    {
        let table = palette.table();
        let mut encoder = Encoder::new(&mut bytes, wide as u16, high as u16, &table)?;
        encoder.set_repeat(Repeat::Infinite)?;
        let mut before: Option<Vec<u8>> = None;
        for (number, picture) in pictures.iter().enumerate() {
            let indexed: Vec<u8> = picture
                .chunks_exact(3)
                .map(|pixel| palette.index([pixel[0], pixel[1], pixel[2]]))
                .collect();
            let last = number + 1 == pictures.len();
            // Hundredths of a second; the last picture stays for a moment.
            let delay = if last { 150 } else { (100.0 / PICTURES_PER_S) as u16 };
            let frame = changed(before.as_deref(), &indexed, wide);
            encoder.write_frame(&Frame { delay, ..frame })?;
            before = Some(indexed);
        }
    }
    Ok(bytes)
}

/// The rectangle that differs from the picture before; unchanged pixels in it are transparent.
fn changed(before: Option<&[u8]>, now: &[u8], wide: usize) -> Frame<'static> {
    let differs = |index: &usize| before.is_none_or(|before| before[*index] != now[*index]);
    let places: Vec<usize> = (0..now.len()).filter(differs).collect();
    let span = |value: fn(usize, usize) -> usize| {
        let values = || places.iter().map(|&index| value(index, wide));
        (values().min().unwrap_or(0), values().max().unwrap_or(0))
    };
    let ((left, right), (top, bottom)) =
        (span(|index, wide| index % wide), span(|index, wide| index / wide));
    let pixels =
        (top..=bottom).flat_map(|row| (left..=right).map(move |column| row * wide + column));
    let buffer: Vec<u8> =
        pixels.map(|index| if differs(&index) { now[index] } else { COLOURS as u8 }).collect();
    Frame {
        left: left as u16,
        top: top as u16,
        width: (right - left + 1) as u16,
        height: (bottom - top + 1) as u16,
        buffer: Cow::Owned(buffer),
        transparent: before.map(|_| COLOURS as u8),
        dispose: DisposalMethod::Keep,
        ..Frame::default()
    }
}

/// The most frequent colours, and the nearest of them to every other one.
struct Palette {
    colours: Vec<[u8; 3]>,
    nearest: HashMap<[u8; 3], u8>,
}

impl Palette {
    fn of(pictures: &[Vec<u8>]) -> Palette {
        let mut counts: HashMap<[u8; 3], usize> = HashMap::new();
        let some = pictures.iter().step_by(pictures.len().div_ceil(12).max(1));
        for pixel in some.flat_map(|picture| picture.chunks_exact(3)) {
            *counts.entry(coarse([pixel[0], pixel[1], pixel[2]])).or_default() += 1;
        }
        let mut colours: Vec<([u8; 3], usize)> = counts.into_iter().collect();
        colours.sort_by(|one, other| other.1.cmp(&one.1).then(one.0.cmp(&other.0)));
        colours.truncate(COLOURS);
        Palette {
            colours: colours.into_iter().map(|(colour, _)| colour).collect(),
            nearest: HashMap::new(),
        }
    }

    fn table(&self) -> Vec<u8> {
        let mut table: Vec<u8> = self.colours.iter().flatten().copied().collect();
        table.resize(3 * (COLOURS + 1), 255);
        table
    }

    fn index(&mut self, colour: [u8; 3]) -> u8 {
        let Palette { colours, nearest } = self;
        *nearest.entry(coarse(colour)).or_insert_with_key(|colour| {
            let away = |other: &[u8; 3]| -> i32 {
                (0..3).map(|k| (i32::from(other[k]) - i32::from(colour[k])).pow(2)).sum()
            };
            let best = colours.iter().enumerate().min_by_key(|(_, other)| away(other));
            best.map_or(0, |(index, _)| index as u8)
        })
    }
}

/// The colour in steps that the eye does not tell apart; white stays white.
fn coarse(colour: [u8; 3]) -> [u8; 3] {
    colour.map(|part| ((u16::from(part) + 2) / 5 * 5).min(255) as u8)
}
