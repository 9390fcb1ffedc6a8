//! Two swept fields: a heat map for each kind of training, mode and policy. The colour is the error
//! over the smallest one of its map, on one scale for all maps.

use super::field::SweptAxis;
use super::{SweepEntry, series_label, sized, training_heading};
use crate::report::drawing::{Canvas, CanvasPoint, Text, TextAlign, text_width};
use crate::report::order::{distinct, trainings};
use crate::report::style::{
    Colour, GREY, HAIR, HALF_CAP, INK, NARROW, SMALL, TALL, TEXT, WHITE, capitalised, heading,
    mode_title,
};

/// Light to dark, so that a grey print keeps the order; ColorBrewer's YlOrBr, safe for colour-blind
/// readers.
const SHADES: [Colour; 6] =
    [[255, 250, 232], [254, 227, 145], [254, 175, 67], [224, 106, 19], [153, 52, 4], [84, 20, 0]];
/// Smallest width of a cell that holds a number.
const MIN_NUMBER_WIDTH: f64 = 36.0;
const MAX_CELL_HEIGHT: f64 = 22.0;
/// Largest height of a map.
const MAX_MAP_HEIGHT: f64 = 300.0;
/// Width for the name of a row.
const NAME_WIDTH: f64 = 160.0;

/// One map: its title and rows.
struct HeatMap<'a> {
    title: String,
    entries: Vec<&'a SweepEntry<'a>>,
}

/// Smallest value of a map, and the ratio to it that is darkest in all maps.
#[derive(Clone, Copy)]
struct ColourScale {
    low_mm: f64,
    darkest: f64,
}

/// Ratios up to this one are not drawn darker than they are, and larger ones are all darkest.
const DARKEST: [f64; 2] = [1.5, 4.0];

/// Sizes of a map.
struct HeatMapLayout {
    /// Width for the names of the rows.
    names: f64,
    cell: [f64; 2],
    /// Number of maps side by side, and the distance between maps.
    columns: usize,
    pitch: [f64; 2],
    /// The ratio to the smallest value that is darkest.
    darkest: f64,
}

/// `blocks` are the values of a third field, each with its rows, or one block without a name.
pub(super) fn draw(
    blocks: &[(String, Vec<&SweepEntry>)],
    [down, across]: [&SweptAxis; 2],
    measure: &str,
    width: f64,
) -> Canvas {
    let titles = all_maps(blocks).map(|map| text_width(&map.title, TEXT, true));
    let title_width = titles.fold(0.0, f64::max);
    let layout = HeatMapLayout::new([down, across], width, darkest(blocks), title_width);
    let mut canvas = Canvas::new(width, TALL);
    canvas.text(Text::new(capitalised(measure), [12.0, 18.0], TEXT, TextAlign::Left));
    let key = if width < NARROW { [12.0, 34.0] } else { [width - 310.0, 18.0] };
    colour_key(&mut canvas, layout.darkest, key);
    let mut top = key[1] + 6.0;
    for (block, entries) in blocks {
        if !block.is_empty() {
            top += 20.0;
            canvas.text(Text::new(block, [12.0, top], TEXT, TextAlign::Left).bold());
        }
        for training in trainings(entries.iter().map(|entry| entry.row.training.as_str())) {
            top = group(&mut canvas, entries, training, [down, across], &layout, top);
        }
    }
    canvas.height = (top + 4.0).round();
    canvas
}

/// The maps of one kind of training below `top`; returns where they end. The names of the rows
/// stand beside the first map of a line.
fn group(
    canvas: &mut Canvas,
    entries: &[&SweepEntry],
    training: &str,
    [down, across]: [&SweptAxis; 2],
    layout: &HeatMapLayout,
    mut top: f64,
) -> f64 {
    if !training_heading(training).is_empty() {
        top += 20.0;
        canvas.text(Text::new(heading(training), [12.0, top], TEXT, TextAlign::Left).bold());
    }
    let maps = maps(entries, training);
    let lines = maps.len().div_ceil(layout.columns);
    // As many in each line, so that no map stands alone.
    let per_line = maps.len().div_ceil(lines.max(1)).max(1);
    for (index, map) in maps.iter().enumerate() {
        let (line, column) = (index / per_line, index % per_line);
        let left = 8.0 + layout.names + layout.pitch[0] * column as f64;
        let corner = [left, top + 26.0 + layout.pitch[1] * line as f64];
        paint(canvas, map, [down, across], layout, corner);
        if column == 0 {
            rows(canvas, down, layout, corner);
        }
    }
    top + layout.pitch[1] * lines as f64
}

/// The maps of one kind of training, mode by mode.
fn maps<'a>(entries: &[&'a SweepEntry<'a>], training: &str) -> Vec<HeatMap<'a>> {
    let of_training: Vec<&'a SweepEntry<'a>> =
        entries.iter().copied().filter(|entry| entry.row.training == training).collect();
    let sized = sized(entries);
    let mut maps = Vec::new();
    for mode in distinct(of_training.iter().map(|entry| entry.row.cell.mode.as_str())) {
        let of_mode: Vec<&'a SweepEntry<'a>> =
            of_training.iter().copied().filter(|entry| entry.row.cell.mode == mode).collect();
        for name in distinct(of_mode.iter().map(|entry| series_label(entry.row, sized))) {
            let of_series =
                of_mode.iter().copied().filter(|entry| series_label(entry.row, sized) == name);
            let mode_words = mode_title(mode);
            let title =
                if mode_words.is_empty() { name.clone() } else { format!("{name}, {mode_words}") };
            maps.push(HeatMap { title, entries: of_series.collect() });
        }
    }
    maps
}

/// One map whose cells begin at `corner`.
fn paint(
    canvas: &mut Canvas,
    map: &HeatMap,
    [down, across]: [&SweptAxis; 2],
    layout: &HeatMapLayout,
    corner: CanvasPoint,
) {
    let [low_mm, _] = range_mm(map.entries.iter().copied());
    let scale = ColourScale { low_mm, darkest: layout.darkest };
    let [wide, high] = layout.cell;
    let (width, height) = (wide * across.values.len() as f64, high * down.values.len() as f64);
    canvas.text(Text::new(&map.title, [corner[0], corner[1] - 6.0], TEXT, TextAlign::Left).bold());
    for entry in &map.entries {
        // The last two fields: what stands before them is the same in all of a block.
        let [.., at_down, at_across] = entry.at.as_slice() else { continue };
        let [Some(row), Some(column)] = [down.index(Some(at_down)), across.index(Some(at_across))]
        else {
            continue;
        };
        let [x, y] = [corner[0] + wide * column as f64, corner[1] + high * row as f64];
        let value_mm = 1e3 * entry.row.mean_m;
        let (ground, ink) = shade(value_mm, scale);
        canvas.rectangle([x, y], [x + wide, y + high], ground, 1.0);
        let label = if value_mm.is_finite() { digits(value_mm, scale) } else { "–".to_owned() };
        if high >= SMALL + 2.0 && text_width(&label, SMALL, false) + 2.0 <= wide {
            let middle = [x + 0.5 * wide, y + 0.5 * high + HALF_CAP * SMALL];
            canvas.text(Text::new(label, middle, SMALL, TextAlign::Centre).colour(ink));
        }
    }
    // Names of columns, skipping those that would overlap.
    let widest = across
        .values
        .iter()
        .map(|value| text_width(&across.shown(value, NAME_WIDTH), SMALL, false))
        .fold(0.0, f64::max);
    let every =
        if across.is_number() { ((widest + 5.0) / wide).ceil().max(1.0) as usize } else { 1 };
    for (column, value) in across.values.iter().enumerate().step_by(every) {
        let room = wide * every as f64 - 3.0;
        let x = corner[0] + wide * (column as f64 + 0.5);
        canvas.text(Text::new(
            across.shown(value, room),
            [x, corner[1] + height + SMALL + 4.0],
            SMALL,
            TextAlign::Centre,
        ));
    }
    let [x1, y1] = [corner[0] + width, corner[1] + height];
    let frame = [corner, [x1, corner[1]], [x1, y1], [corner[0], y1], corner];
    canvas.line(&frame, HAIR, GREY, &[]);
    let below = [corner[0] + 0.5 * width, y1 + SMALL + TEXT + 8.0];
    canvas.text(Text::new(across.label(layout.pitch[0]), below, TEXT, TextAlign::Centre));
}

/// The names of the rows of a map, skipping those that would overlap, and the field's.
fn rows(canvas: &mut Canvas, down: &SweptAxis, layout: &HeatMapLayout, corner: CanvasPoint) {
    let high = layout.cell[1];
    let every = ((SMALL + 2.0) / high).ceil().max(1.0) as usize;
    for (row, value) in down.values.iter().enumerate().step_by(every) {
        let y = corner[1] + high * (row as f64 + 0.5) + HALF_CAP * SMALL;
        canvas.text(Text::new(
            down.shown(value, NAME_WIDTH),
            [corner[0] - 5.0, y],
            SMALL,
            TextAlign::Right,
        ));
    }
    let above = [corner[0] - 5.0, corner[1] - 6.0];
    canvas.text(Text::new(down.label(NAME_WIDTH), above, SMALL, TextAlign::Right).colour(GREY));
}

/// Smallest and largest mean, millimetres.
fn range_mm<'a>(entries: impl Iterator<Item = &'a SweepEntry<'a>>) -> [f64; 2] {
    let means_mm = entries.map(|entry| 1e3 * entry.row.mean_m).filter(|value| value.is_finite());
    means_mm.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
        [low.min(value), high.max(value)]
    })
}

/// The maps of all blocks and kinds of training.
fn all_maps<'a>(
    blocks: &'a [(String, Vec<&'a SweepEntry<'a>>)],
) -> impl Iterator<Item = HeatMap<'a>> {
    blocks.iter().flat_map(|(_, entries)| {
        let kinds = trainings(entries.iter().map(|entry| entry.row.training.as_str()));
        kinds.into_iter().flat_map(|training| maps(entries, training))
    })
}

/// The ratio that is darkest: the largest one of all maps, within bounds.
fn darkest(blocks: &[(String, Vec<&SweepEntry>)]) -> f64 {
    let ratios = all_maps(blocks).map(|map| {
        let [low_mm, high_mm] = range_mm(map.entries.into_iter());
        high_mm / low_mm
    });
    ratios.filter(|ratio| ratio.is_finite()).fold(DARKEST[0], f64::max).min(DARKEST[1])
}

/// The scale of colours with the ratios at its ends, its baseline at `at`.
fn colour_key(canvas: &mut Canvas, darkest: f64, [x, y]: CanvasPoint) {
    const STEPS: usize = 24;
    const STEP_WIDTH: f64 = 3.0;
    let words = "error over the smallest: 1×";
    canvas.text(Text::new(words, [x, y], SMALL, TextAlign::Left));
    let left = x + text_width(words, SMALL, false) + 5.0;
    for step in 0..STEPS {
        let share = step as f64 / (STEPS - 1) as f64;
        let scale = ColourScale { low_mm: 1.0, darkest };
        let (colour, _) = shade(1.0 + share * (darkest - 1.0), scale);
        let from = left + STEP_WIDTH * step as f64;
        canvas.rectangle([from, y - 8.5], [from + STEP_WIDTH + 0.1, y + 1.5], colour, 1.0);
    }
    let more = if darkest < DARKEST[1] { "" } else { " and more" };
    let end = [left + STEP_WIDTH * STEPS as f64 + 5.0, y];
    canvas.text(Text::new(format!("{darkest:.1}×{more}"), end, SMALL, TextAlign::Left));
}

/// A number with three significant digits of the smallest one of its map.
fn digits(value_mm: f64, scale: ColourScale) -> String {
    let largest = scale.low_mm.abs().max(1e-12);
    let places = (2.0 - largest.log10().floor()).clamp(0.0, 4.0) as usize;
    if value_mm.is_finite() { format!("{value_mm:.places$}") } else { "–".to_owned() }
}

/// Colour of a cell and of its number.
fn shade(value_mm: f64, ColourScale { low_mm, darkest }: ColourScale) -> (Colour, Colour) {
    if !value_mm.is_finite() {
        return (WHITE, GREY);
    }
    let share = (value_mm / low_mm - 1.0) / (darkest - 1.0);
    let share = if share.is_finite() { share } else { 0.0 };
    let place = share.clamp(0.0, 1.0) * (SHADES.len() - 1) as f64;
    let first = (place.floor() as usize).min(SHADES.len() - 2);
    let part = place - first as f64;
    let mix = |channel: usize| {
        let [from, to] = [SHADES[first][channel], SHADES[first + 1][channel]].map(f64::from);
        (from + part * (to - from)).round() as u8
    };
    let ground = [mix(0), mix(1), mix(2)];
    (ground, if contrast(ground, WHITE) > contrast(ground, INK) { WHITE } else { INK })
}

/// Contrast ratio of two colours by the Web Content Accessibility Guidelines 2.1, at least 1.
fn contrast(one: Colour, other: Colour) -> f64 {
    let light = |colour: Colour| {
        let part = |index: usize| {
            let value = f64::from(colour[index]) / 255.0;
            if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * part(0) + 0.7152 * part(1) + 0.0722 * part(2) + 0.05
    };
    let (one, other) = (light(one), light(other));
    one.max(other) / one.min(other)
}

impl HeatMapLayout {
    fn new(
        [down, across]: [&SweptAxis; 2],
        width: f64,
        darkest: f64,
        title_width: f64,
    ) -> HeatMapLayout {
        let widest = down
            .values
            .iter()
            .map(|value| text_width(&down.shown(value, NAME_WIDTH), SMALL, false))
            .fold(0.0, f64::max);
        let names = widest.max(text_width(&down.label(NAME_WIDTH), SMALL, false)) + 14.0;
        let label_width = across
            .values
            .iter()
            .map(|value| text_width(&across.shown(value, NAME_WIDTH), SMALL, false) + 8.0);
        let label_width = label_width.fold(MIN_NUMBER_WIDTH, f64::max);
        let free_width = width - 24.0 - names;
        let wide = label_width.min(free_width / across.values.len() as f64);
        let high = MAX_CELL_HEIGHT.min(MAX_MAP_HEIGHT / down.values.len() as f64);
        // A title may be longer than its map.
        let map = (wide * across.values.len() as f64).max(title_width) + 16.0;
        let columns = (((width - 12.0 - names) / map).floor() as usize).max(1);
        HeatMapLayout {
            names,
            cell: [wide, high],
            columns,
            pitch: [map, high * down.values.len() as f64 + 64.0],
            darkest,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shades_grow_darker_and_numbers_on_them_are_read() {
        let scale = ColourScale { low_mm: 1.0, darkest: 2.0 };
        let shades: Vec<(Colour, Colour)> =
            (100..=200).map(|step| shade(0.01 * f64::from(step), scale)).collect();
        assert!(
            shades.windows(2).all(|pair| contrast(pair[0].0, WHITE) < contrast(pair[1].0, WHITE))
        );
        // On a ground halfway between white and ink neither stands out by more than the root of
        // their own contrast.
        let min_contrast = contrast(WHITE, INK).sqrt() * 0.99;
        for (ground, ink) in shades {
            assert!(contrast(ground, ink) > min_contrast, "{ground:?}");
        }
        assert_eq!(shade(f64::NAN, scale), (WHITE, GREY));
        assert_eq!(shade(1.0, scale).0, SHADES[0]);
        assert_eq!(shade(9.0, scale).0, SHADES[SHADES.len() - 1]);
    }
}
