//! Confusion matrix: injected effects by row, answers by column.

use std::collections::BTreeMap;

use serde::Serialize;

use super::cases::AnswerClass;
use crate::data::findings::CaseRow;
use crate::report::discovery::format::fitted;
use crate::report::drawing::{
    Canvas, CanvasPoint, LegendEntry, Text, TextAlign, legend, text_width,
};
use crate::report::order::distinct;
use crate::report::style::{
    BLUE, Colour, GREY, HAIR, HALF_CAP, INK, Marker, NARROW, PAGE_WIDTH, SKY, SMALL, TALL, TEXT,
    VERMILION, WHITE,
};

/// Number of cases with one truth and one answer (`confusion.csv`).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct CountRow {
    /// Group of the cases.
    pub(crate) group: String,
    /// Injected effects; empty for none.
    pub(crate) truth: String,
    /// Named effects, or the class of the answer.
    pub(crate) answer: String,
    pub(crate) cases: u64,
    /// Number of right answers.
    pub(crate) right: u64,
}

/// Groups in row order; pairs have no row in the figure.
const GROUPS: [(&str, &str); 4] = [
    ("single", "One effect hidden"),
    ("nothing", "Nothing hidden"),
    ("outside", "Outside the catalogue"),
    ("inside", "Unknown, within its span"),
];

const LEFT_MARGIN: f64 = 168.0;
const ROW_HEIGHT: f64 = 17.0;

/// Every truth and answer that occurs, truths by kind and in order of appearance.
pub(crate) fn counts(cases: &[CaseRow]) -> Vec<CountRow> {
    let kinds = ["nothing", "single", "pair", "outside", "inside"];
    let place = |group: &str| kinds.iter().position(|name| *name == group).unwrap_or(kinds.len());
    let truths = distinct(cases.iter().map(|case| case.truth.as_str()));
    let mut counts_by_answer: BTreeMap<(usize, String, usize, String), [u64; 2]> = BTreeMap::new();
    for case in cases {
        let truth = truths.iter().position(|truth| *truth == case.truth).unwrap_or(truths.len());
        let answer = match AnswerClass::of(case) {
            AnswerClass::Several => case.answer.clone(),
            other => other.name().to_owned(),
        };
        let count = counts_by_answer
            .entry((place(&case.group), case.group.clone(), truth, answer))
            .or_default();
        count[0] += 1;
        count[1] += u64::from(case.right);
    }
    let row = |((_, group, truth, answer), [cases, right]): (
        (usize, String, usize, String),
        [u64; 2],
    )| CountRow { group, truth: truths[truth].to_owned(), answer, cases, right };
    counts_by_answer.into_iter().map(row).collect()
}

/// A row of the figure.
struct MatrixRow<'a> {
    group: &'a str,
    truth: &'a str,
    cases: Vec<&'a CaseRow>,
}

fn lines(cases: &[CaseRow]) -> Vec<MatrixRow<'_>> {
    let mut lines = Vec::new();
    for (group, _) in GROUPS {
        let of_group: Vec<&CaseRow> = cases.iter().filter(|case| case.group == group).collect();
        for truth in distinct(of_group.iter().map(|case| case.truth.as_str())) {
            let cases = of_group.iter().copied().filter(|case| case.truth == truth).collect();
            lines.push(MatrixRow { group, truth, cases });
        }
    }
    lines
}

/// Columns: hidden single effects in the order of their lines, other names that were given, then
/// the other answers.
fn columns(lines: &[MatrixRow]) -> Vec<AnswerClass> {
    let hidden =
        lines.iter().filter(|line| line.group == "single").map(|line| line.truth.to_owned());
    let mut columns: Vec<AnswerClass> = hidden.map(AnswerClass::Named).collect();
    let answers = lines.iter().flat_map(|line| line.cases.iter().map(|case| AnswerClass::of(case)));
    let mut other_names: Vec<AnswerClass> = answers
        .filter(|answer| matches!(answer, AnswerClass::Named(_)) && !columns.contains(answer))
        .collect();
    other_names.sort();
    other_names.dedup();
    columns.extend(other_names);
    columns.extend(AnswerClass::OTHERS);
    columns
}

/// What the picture shows.
pub(crate) fn caption(cases: &[CaseRow]) -> String {
    format!(
        "Answers of discovery to {} blind cases: one row per hidden effect, one column per answer, \
         the number of cases in each cell; stronger colour: larger share of the row. At column \
         width: the answers other than the hidden effect, in words.",
        cases.len()
    )
}

/// Draws the matrix; where there is no room for its columns, the answers in words.
pub(crate) fn draw(cases: &[CaseRow], width: f64) -> Canvas {
    let lines = lines(cases);
    if width < NARROW {
        return in_words(&lines, width);
    }
    let columns = columns(&lines);
    let mut canvas = Canvas::new(PAGE_WIDTH, TALL);
    keys(&mut canvas);
    let wide = (PAGE_WIDTH - LEFT_MARGIN - 44.0) / columns.len() as f64;
    let size = SMALL.min(0.9 * wide);
    let names: Vec<String> =
        columns.iter().map(|column| fitted(column.name(), size, 180.0)).collect();
    let longest = names.iter().map(|name| text_width(name, size, false)).fold(0.0, f64::max);
    let top = 44.0 + longest;
    for (index, (answer, name)) in columns.iter().zip(&names).enumerate() {
        let x = LEFT_MARGIN + wide * (index as f64 + 0.5) + HALF_CAP * size + gap(answer);
        let colour = if matches!(answer, AnswerClass::Named(_)) { INK } else { GREY };
        canvas
            .text(Text::new(name, [x, top - 6.0], size, TextAlign::Left).upwards().colour(colour));
    }
    canvas.text(Text::new("answer", [12.0, top - 6.0], SMALL, TextAlign::Left).colour(GREY));
    canvas.text(
        Text::new("cases", [PAGE_WIDTH - 10.0, top - 6.0], SMALL, TextAlign::Right).colour(GREY),
    );
    let mut y = top;
    let mut group = "";
    for line in &lines {
        if line.group != group {
            group = line.group;
            y = heading(&mut canvas, group, y);
        }
        let name = if line.truth.is_empty() { "nothing" } else { line.truth };
        let name = fitted(name, SMALL, LEFT_MARGIN - 28.0);
        canvas.text(Text::new(
            name,
            [LEFT_MARGIN - 8.0, y + 0.5 * ROW_HEIGHT + 3.5],
            SMALL,
            TextAlign::Right,
        ));
        for (index, column) in columns.iter().enumerate() {
            let corner = [LEFT_MARGIN + wide * index as f64 + gap(column), y];
            cell(&mut canvas, line, column, corner, wide);
        }
        let count = line.cases.len().to_string();
        canvas.text(
            Text::new(
                count,
                [PAGE_WIDTH - 10.0, y + 0.5 * ROW_HEIGHT + 3.5],
                SMALL,
                TextAlign::Right,
            )
            .colour(GREY),
        );
        y += ROW_HEIGHT;
    }
    if lines.is_empty() {
        canvas.text(Text::new(
            "no case with one effect, an unknown one or none",
            [12.0, y + 16.0],
            TEXT,
            TextAlign::Left,
        ));
        y += 24.0;
    }
    canvas.height = (y + 14.0).ceil();
    canvas
}

/// A bar for each row, right answers first, and the other answers in words.
fn in_words(rows: &[MatrixRow], width: f64) -> Canvas {
    const NAMES: f64 = 120.0;
    const BAR: f64 = 40.0;
    let mut canvas = Canvas::new(width, TALL);
    let keys: [(LegendEntry, &str); 3] =
        [(BLUE, "right"), (SKY, "truth in the group"), (VERMILION, "not right")]
            .map(|(colour, words)| (LegendEntry::Marker(Marker::Square, colour, false), words));
    let mut y = legend(&mut canvas, [10.0, 16.0], width - 8.0, &keys) + 10.0;
    let mut group = "";
    for row in rows {
        if row.group != group {
            group = row.group;
            y = heading(&mut canvas, group, y);
        }
        let base = y + 0.5 * ROW_HEIGHT + HALF_CAP * SMALL;
        let name = if row.truth.is_empty() { "nothing" } else { row.truth };
        let name = fitted(&name.replace('_', " "), SMALL, NAMES - 16.0);
        canvas.text(Text::new(name, [NAMES - 6.0, base], SMALL, TextAlign::Right));
        let mut answers: Vec<(AnswerClass, Colour, usize)> = Vec::new();
        for case in &row.cases {
            let answer = AnswerClass::of(case);
            let colour = if case.right {
                BLUE
            } else if matches!(answer, AnswerClass::GroupWith | AnswerClass::Group) {
                SKY
            } else {
                VERMILION
            };
            match answers.iter_mut().find(|(other, hue, _)| *other == answer && *hue == colour) {
                Some((_, _, count)) => *count += 1,
                None => answers.push((answer, colour, 1)),
            }
        }
        answers.sort_by_key(|(_, colour, count)| {
            (*colour != BLUE, *colour != SKY, usize::MAX - count)
        });
        let mut x = NAMES;
        for (_, colour, count) in &answers {
            let end = x + BAR * *count as f64 / row.cases.len() as f64;
            canvas.rectangle([x, y + 2.0], [end - 0.6, y + ROW_HEIGHT - 2.0], *colour, 1.0);
            x = end;
        }
        let own = AnswerClass::Named(row.truth.to_owned());
        let words: Vec<String> = answers
            .iter()
            .filter(|(answer, _, _)| *answer != own)
            .map(|(answer, _, count)| format!("{count} × {}", answer.name().replace('_', " ")))
            .collect();
        let words = fitted(&words.join(", "), SMALL, width - NAMES - BAR - 14.0);
        canvas.text(Text::new(words, [NAMES + BAR + 6.0, base], SMALL, TextAlign::Left));
        y += ROW_HEIGHT;
    }
    canvas.height = (y + 8.0).round();
    canvas
}

/// Gap before columns of classes.
fn gap(answer: &AnswerClass) -> f64 {
    if matches!(answer, AnswerClass::Named(_)) { 0.0 } else { 6.0 }
}

fn heading(canvas: &mut Canvas, group: &str, y: f64) -> f64 {
    let words = GROUPS.iter().find(|(name, _)| *name == group).map_or(group, |(_, words)| *words);
    canvas.text(Text::new(words, [12.0, y + 13.0], SMALL, TextAlign::Left).bold());
    let right = canvas.width - 10.0;
    canvas.line(&[[12.0, y], [right, y]], HAIR, crate::report::style::GRID, &[]);
    y + 18.0
}

fn keys(canvas: &mut Canvas) {
    let mut x = 12.0;
    for (colour, words) in
        [(BLUE, "right"), (SKY, "the truth is in the group"), (VERMILION, "not right")]
    {
        canvas.rectangle([x, 9.0], [x + 13.0, 20.0], colour, 1.0);
        canvas.text(Text::new(words, [x + 18.0, 18.0], SMALL, TextAlign::Left));
        x += 34.0 + text_width(words, SMALL, false);
    }
}

/// Number of cases of a row with an answer; darker for a larger share.
fn cell(
    canvas: &mut Canvas,
    line: &MatrixRow,
    column: &AnswerClass,
    [x, y]: CanvasPoint,
    wide: f64,
) {
    let [from, to] = [[x + 0.5, y + 0.5], [x + wide - 0.5, y + ROW_HEIGHT - 0.5]];
    let matching_cases: Vec<&&CaseRow> =
        line.cases.iter().filter(|case| AnswerClass::of(case) == *column).collect();
    if matching_cases.is_empty() {
        canvas.rectangle(from, to, [244, 244, 244], 1.0);
        return;
    }
    let right = 2 * matching_cases.iter().filter(|case| case.right).count() >= matching_cases.len();
    let hue = match column {
        _ if right => BLUE,
        AnswerClass::GroupWith | AnswerClass::Group => SKY,
        _ => VERMILION,
    };
    let share = matching_cases.len() as f64 / line.cases.len() as f64;
    let colour = mixed(hue, 0.25 + 0.75 * share.sqrt());
    canvas.rectangle(from, to, colour, 1.0);
    let count = matching_cases.len().to_string();
    let size = SMALL.min(SMALL * 0.86 * wide / text_width(&count, SMALL, false).max(1.0));
    let ink = if luminance(colour) > 0.3 { INK } else { WHITE };
    let middle = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1]) + HALF_CAP * size];
    canvas.text(Text::new(count, middle, size, TextAlign::Centre).colour(ink));
}

/// A colour mixed with white.
fn mixed(colour: Colour, share: f64) -> Colour {
    colour.map(|part| (255.0 - share * (255.0 - f64::from(part))).round() as u8)
}

/// Relative luminance, roughly.
fn luminance([red, green, blue]: Colour) -> f64 {
    let part = |value: u8| (f64::from(value) / 255.0).powf(2.2);
    0.2126 * part(red) + 0.7152 * part(green) + 0.0722 * part(blue)
}
