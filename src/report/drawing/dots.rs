//! Dots in named rows, panels side by side: every row carries its name, so that no reader has to
//! look up a dozen colours.

use super::axes::{Axis, Panel};
use super::canvas::{Canvas, Text, TextAlign};
use super::paint::text_width;
use super::words::lines;
use crate::report::style::{
    Colour, GREEN, GREY, GRID, HAIR, HALF_CAP, MARKER, Marker, SMALL, TEXT,
};

/// Least width of a panel without words.
pub(crate) const MIN_PANEL: f64 = 56.0;
/// Room between two panels.
const GAP: f64 = 18.0;
/// Below the panels: numbers and label of the axis, and the title of the next line of panels.
const BELOW: f64 = 62.0;

/// A row of a chart.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum DotRow {
    /// Words in bold above rows that belong together, without dots.
    Heading(String),
    /// A name, and how many lanes its dots take.
    Named(String, usize),
}

/// A dot in a row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Dot {
    pub(crate) row: usize,
    /// Lane within the row, from above.
    pub(crate) lane: usize,
    /// Place along the axis.
    pub(crate) value: f64,
    /// Ends of a thin and of a thick line through the dot.
    pub(crate) thin: Option<[f64; 2]>,
    pub(crate) thick: Option<[f64; 2]>,
    pub(crate) marker: Marker,
    pub(crate) colour: Colour,
    pub(crate) hollow: bool,
    /// Words beside the dot; alone where the value is not finite.
    pub(crate) words: String,
}

/// A panel of a chart.
pub(crate) struct DotPanel {
    pub(crate) title: String,
    pub(crate) x: Axis,
    pub(crate) dots: Vec<Dot>,
    /// Whether a grey line joins the dots of a lane.
    pub(crate) joined: bool,
    /// Ranges behind the dots of a row: what is to be reached.
    pub(crate) goals: Vec<(usize, [f64; 2])>,
}

impl DotPanel {
    /// A panel of dots alone.
    pub(crate) fn new(title: &str, x: Axis, dots: Vec<Dot>) -> DotPanel {
        DotPanel { title: title.to_owned(), x, dots, joined: false, goals: Vec::new() }
    }
}

/// Rows, and panels beside them.
pub(crate) struct DotChart {
    pub(crate) rows: Vec<DotRow>,
    /// Height of a lane, and least width of a panel.
    pub(crate) lane_height: f64,
    pub(crate) min_panel: f64,
    /// Width right of a panel for the words of its dots; without it they stand beside the dots.
    pub(crate) aside: f64,
    pub(crate) panels: Vec<DotPanel>,
}

/// A row with its name in lines.
struct PlacedRow {
    lines: Vec<String>,
    /// Distance below the upper edge.
    top: f64,
    high: f64,
}

impl DotChart {
    /// Draws the chart below `top`, as many panels side by side as fit. Returns where it ends.
    pub(crate) fn draw(&self, canvas: &mut Canvas, top: f64) -> f64 {
        let left = self.names_width().min(0.42 * canvas.width);
        let rows: Vec<PlacedRow> = self.placed(left - 17.0);
        let right = canvas.width - 14.0;
        let gap = GAP + self.aside;
        let fitting = ((right - left + GAP) / (self.min_panel + gap)).floor().max(1.0) as usize;
        let lines = self.panels.len().div_ceil(fitting).max(1);
        // As many in each line, so that no panel stands alone.
        let per_line = self.panels.len().div_ceil(lines).max(1);
        let wide = (right - left + GAP) / per_line as f64 - gap;
        let title = |panel: &DotPanel| lines_bold(&panel.title, wide + 10.0).len();
        let title_lines = self.panels.iter().map(title).max().unwrap_or(0).max(1);
        let top = top + (TEXT + 2.0) * (title_lines - 1) as f64;
        let below = BELOW + (TEXT + 2.0) * (title_lines - 1) as f64;
        let high: f64 = rows.iter().map(|row| row.high).sum();
        let mut bottom = top;
        for (line, panels) in self.panels.chunks(per_line).enumerate() {
            let upper = top + (high + below) * line as f64;
            self.names(canvas, &rows, [left, right], upper);
            for (place, panel) in panels.iter().enumerate() {
                let corner = [left + (wide + gap) * place as f64, upper];
                self.panel(canvas, panel, &rows, corner, [wide, high]);
            }
            bottom = upper + high + BELOW - 18.0;
        }
        bottom
    }

    fn names_width(&self) -> f64 {
        let wide = |row: &DotRow| match row {
            DotRow::Heading(_) => 0.0,
            DotRow::Named(name, _) => text_width(name, SMALL, false),
        };
        self.rows.iter().map(wide).fold(30.0, f64::max) + 18.0
    }

    /// The rows from above, with names in lines of this width.
    fn placed(&self, room: f64) -> Vec<PlacedRow> {
        let mut top = 0.0;
        let place = |row: &DotRow| {
            let (lines, high) = match row {
                DotRow::Heading(words) => (vec![words.clone()], TEXT + 7.0),
                DotRow::Named(name, lanes) => {
                    let lines = lines(name, SMALL, room);
                    let lanes_high = self.lane_height * (*lanes).max(1) as f64;
                    let high = lanes_high.max((SMALL + 1.5) * lines.len() as f64) + 3.0;
                    (lines, high)
                }
            };
            let row = PlacedRow { lines, top, high };
            top += high;
            row
        };
        self.rows.iter().map(place).collect()
    }

    fn names(&self, canvas: &mut Canvas, rows: &[PlacedRow], [left, right]: [f64; 2], top: f64) {
        let lanes = self.rows.iter().any(|row| matches!(row, DotRow::Named(_, 2..)));
        for (index, (row, place)) in self.rows.iter().zip(rows).enumerate() {
            let y = top + place.top;
            if (index > 0 && lanes) || matches!(row, DotRow::Heading(_)) {
                canvas.line(&[[10.0, y], [right, y]], HAIR, GRID, &[]);
            }
            if let DotRow::Heading(words) = row {
                let at = [10.0, y + TEXT + 2.0];
                canvas.text(Text::new(words, at, TEXT, TextAlign::Left).bold());
                continue;
            }
            let middle = y + 0.5 * place.high;
            for (line, words) in place.lines.iter().enumerate() {
                let away = line as f64 - 0.5 * (place.lines.len() - 1) as f64;
                let base = middle + HALF_CAP * SMALL + (SMALL + 1.5) * away;
                canvas.text(Text::new(words, [left - 8.0, base], SMALL, TextAlign::Right));
            }
        }
    }

    fn panel(
        &self,
        canvas: &mut Canvas,
        panel: &DotPanel,
        rows: &[PlacedRow],
        corner: [f64; 2],
        size: [f64; 2],
    ) {
        let frame = canvas.panel(Panel {
            corner,
            size,
            x: panel.x.clone(),
            y: Axis::bare_to(1.0),
            title: String::new(),
        });
        for (line, words) in lines_bold(&panel.title, size[0] + 10.0).iter().rev().enumerate() {
            let at = [corner[0], corner[1] - 6.0 - (TEXT + 2.0) * line as f64];
            canvas.text(Text::new(words, at, TEXT, TextAlign::Left).bold());
        }
        let y = |dot: &Dot| {
            let row = &rows[dot.row.min(rows.len() - 1)];
            let lanes = match &self.rows[dot.row.min(rows.len() - 1)] {
                DotRow::Named(_, lanes) => (*lanes).max(1),
                DotRow::Heading(_) => 1,
            };
            let away = dot.lane as f64 - 0.5 * (lanes - 1) as f64;
            corner[1] + row.top + 0.5 * row.high + self.lane_height * away
        };
        let x = |value: f64| frame.at(value.clamp(frame.x.low, frame.x.high), 0.0)[0];
        for (row, goal) in &panel.goals {
            let row = &rows[(*row).min(rows.len() - 1)];
            let [from, to] = goal.map(x);
            let [upper, lower] = [corner[1] + row.top + 1.5, corner[1] + row.top + row.high - 1.5];
            canvas.rectangle([from - 0.8, upper], [to + 0.8, lower], GREEN, 0.25);
        }
        if panel.joined {
            let finite: Vec<&Dot> = panel.dots.iter().filter(|dot| dot.value.is_finite()).collect();
            for (index, dot) in finite.iter().enumerate() {
                if let Some(next) = finite[index + 1..].iter().find(|next| y(next) == y(dot)) {
                    canvas.line(
                        &[[x(dot.value), y(dot)], [x(next.value), y(next)]],
                        HAIR,
                        GREY,
                        &[],
                    );
                }
            }
        }
        for dot in &panel.dots {
            let middle = y(dot);
            let ends = mark(canvas, dot, &x, middle).unwrap_or([corner[0]; 2]);
            let (at, align) = if self.aside > 0.0 {
                (corner[0] + size[0] + self.aside, TextAlign::Right)
            } else {
                (ends[1] + 5.0, TextAlign::Left)
            };
            let words = Text::new(&dot.words, [at, middle + HALF_CAP * SMALL], SMALL, align);
            canvas.text(words.colour(dot.colour));
        }
    }
}

/// Draws a dot with its lines at a height. Returns its ends; none of a dot without a place.
fn mark(canvas: &mut Canvas, dot: &Dot, x: &impl Fn(f64) -> f64, y: f64) -> Option<[f64; 2]> {
    if !dot.value.is_finite() {
        return None;
    }
    let middle = x(dot.value);
    let mut ends = [middle - 4.0, middle + 4.0];
    for (line, width) in [(dot.thin, 1.1), (dot.thick, 3.6)] {
        if let Some(line) = line.filter(|ends| ends.iter().all(|end| end.is_finite())) {
            let [low, high] = line.map(x);
            canvas.line(&[[low, y], [high, y]], width, dot.colour, &[]);
            ends = [ends[0].min(low), ends[1].max(high)];
        }
    }
    canvas.marker([middle, y], dot.marker, MARKER, dot.colour, dot.hollow);
    Some(ends)
}

/// A title in lines.
fn lines_bold(title: &str, room: f64) -> Vec<String> {
    // Bold letters are about a ninth wider.
    lines(title, TEXT, 0.9 * room)
}

impl Dot {
    /// A dot without lines and words.
    pub(crate) fn new(row: usize, lane: usize, value: f64, marker: Marker, colour: Colour) -> Dot {
        Dot {
            row,
            lane,
            value,
            thin: None,
            thick: None,
            marker,
            colour,
            hollow: false,
            words: String::new(),
        }
    }
}
