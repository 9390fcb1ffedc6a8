//! Names at the ends of lines, in place of a legend.

use super::axes::Panel;
use super::canvas::{Canvas, CanvasPoint, Text, TextAlign};
use super::paint::text_width;
use crate::report::style::{Colour, DOTTED, GREY, HAIR, HALF_CAP, SMALL};

/// Distance of two names, and from the end of a line to its name.
const PITCH: f64 = SMALL + 1.5;
const AWAY: f64 = 8.0;

/// The end of a line and its name.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LineEnd {
    pub(crate) at: CanvasPoint,
    pub(crate) name: String,
    pub(crate) colour: Colour,
}

/// Width of the longest of these names with its distance from the line.
pub(crate) fn ends_width<'a>(names: impl Iterator<Item = &'a str>) -> f64 {
    names.map(|name| text_width(name, SMALL, false)).fold(0.0, f64::max) + 2.0 * AWAY
}

/// Writes the names right of a panel, in the order of the ends of their lines, and joins a name
/// that had to move with its line.
pub(crate) fn name_ends(canvas: &mut Canvas, panel: &Panel, mut ends: Vec<LineEnd>) {
    ends.sort_by(|one, other| one.at[1].total_cmp(&other.at[1]));
    let [top, bottom] = [panel.corner[1], panel.corner[1] + panel.size[1]];
    let wanted: Vec<f64> = ends.iter().map(|end| end.at[1]).collect();
    let x = panel.corner[0] + panel.size[0] + AWAY + 4.0;
    for (end, y) in ends.iter().zip(spread(&wanted, PITCH, [top - 4.0, bottom + 4.0])) {
        let knee = [x - 6.0, y];
        let bends = (y - end.at[1]).abs() > 1.0 || knee[0] - end.at[0] > 2.0 * AWAY;
        if bends {
            let from = [end.at[0] + 4.0, end.at[1]];
            canvas.line(&[from, knee, [x - 2.0, y]], 0.7 * HAIR, GREY, DOTTED);
        }
        let base = [x, y + HALF_CAP * SMALL];
        canvas.text(Text::new(&end.name, base, SMALL, TextAlign::Left).colour(end.colour));
    }
}

/// Places at least `pitch` apart, near the `wanted` ones (ascending) and between two ends.
fn spread(wanted: &[f64], pitch: f64, [low, high]: [f64; 2]) -> Vec<f64> {
    // Blocks of neighbours that touch: sum of wanted places less their offsets, and their number.
    let mut blocks: Vec<(f64, usize)> = Vec::new();
    let start = |&(sum, count): &(f64, usize)| {
        let last = high - pitch * (count - 1) as f64;
        (sum / count as f64).min(last).max(low)
    };
    for &place in wanted {
        blocks.push((place, 1));
        while let [.., one, other] = blocks.as_slice() {
            let end = start(one) + pitch * one.1 as f64;
            if start(other) >= end {
                break;
            }
            let shift = pitch * one.1 as f64 * other.1 as f64;
            let merged = (one.0 + other.0 - shift, one.1 + other.1);
            blocks.truncate(blocks.len() - 2);
            blocks.push(merged);
        }
    }
    let places = blocks.iter().flat_map(|block| {
        let first = start(block);
        (0..block.1).map(move |index| first + pitch * index as f64)
    });
    places.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_apart_and_near_their_lines() {
        assert_eq!(spread(&[0.0, 30.0], 10.0, [-5.0, 100.0]), [0.0, 30.0]);
        assert_eq!(
            spread(&[20.0, 20.0, 22.0], 10.0, [0.0, 100.0]),
            [32.0 / 3.0, 32.0 / 3.0 + 10.0, 32.0 / 3.0 + 20.0]
        );
        assert_eq!(spread(&[98.0, 99.0], 10.0, [0.0, 100.0]), [90.0, 100.0]);
    }
}
