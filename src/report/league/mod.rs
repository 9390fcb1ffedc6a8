//! The board of a league: tables, a figure, and a page of both.

use maud::html;

use super::discovery::html::{document, figure};
use super::drawing::{Axis, Canvas, Dot, DotChart, DotPanel, DotRow};
use super::page::markup::MarkdownTable;
use super::style::{GREY, INK, Marker, TALL};
use super::{Artifact, ReportError, captioned, csv, text};
use crate::rows::league::BoardRow;

/// Stem of the files of the figure; its caption is Markdown, as the table is.
const NAME: &str = "board_errors";

/// The files of a board: CSV, JSON, Markdown, a page, and its figure.
///
/// # Errors
/// [`ReportError`] where nothing can be drawn or written.
pub fn board(rows: &[BoardRow]) -> Result<Vec<Artifact>, ReportError> {
    if rows.is_empty() {
        return Err(ReportError::NoRows { figure: NAME, needs: "scores" });
    }
    let json = serde_json::to_string_pretty(rows).unwrap_or_default() + "\n";
    let mut files = vec![
        csv("board.csv", rows)?,
        text("board.json", json),
        text("board.md", markdown(rows)),
        text("board.html", page(rows)?),
    ];
    files.extend(captioned(NAME, NAME, CAPTION, |width| draw(rows, width))?);
    Ok(files)
}

const CAPTION: &str = "Board of the league: mean error over robots in % of the length of the robot, on a logarithmic axis, \
     with its 95 % interval over robots; of the track `name`, the share of robots whose effects are not named. Grey, hollow: \
     a controller that knows the hidden effects.";

/// The tables of a board, one for each track, season and family.
fn groups(rows: &[BoardRow]) -> Vec<(String, Vec<&BoardRow>)> {
    let mut groups: Vec<(String, Vec<&BoardRow>)> = Vec::new();
    for row in rows {
        let title = format!("{}: {}, {}", row.track, row.robots, row.season);
        match groups.iter_mut().find(|(other, _)| *other == title) {
            Some((_, group)) => group.push(row),
            None => groups.push((title, vec![row])),
        }
    }
    groups
}

/// A table: ranks, names, errors.
fn table(rows: &[&BoardRow]) -> MarkdownTable {
    let number = |value: f64, digits: usize| {
        if value.is_finite() { format!("{value:.digits$}") } else { "–".to_owned() }
    };
    let cells = rows.iter().map(|row| {
        vec![
            row.rank.to_string(),
            row.name.clone(),
            row.kind.clone(),
            number(100.0 * row.error, 2),
            format!("[{}, {}]", number(100.0 * row.low_95, 2), number(100.0 * row.high_95, 2)),
            number(100.0 * row.floor, 2),
            row.samples.to_string(),
            number(row.tick_ms, 2),
            format!("{} of {}", row.failed, row.trials),
        ]
    });
    MarkdownTable::new(
        "Rank | Submission | Kind | Error, % of length | 95 % interval | Floor, % | Samples | Tick, ms | Failed trials",
        cells,
    )
}

fn markdown(rows: &[BoardRow]) -> String {
    let mut out = String::from("# Board of the league\n");
    for (title, group) in groups(rows) {
        out += &format!("\n## {title}\n\n{}", table(&group).markdown());
    }
    out + "\nA rank counts the submissions whose interval lies wholly below. Overlapping intervals share a rank.\n"
}

fn page(rows: &[BoardRow]) -> Result<String, ReportError> {
    let drawing = figure(NAME, |width| Some(draw(rows, width)))?;
    let content = html! {
        h1 { "Board of the league" }
        p { "Ranks count the submissions whose 95 % interval lies wholly below; overlapping intervals share a rank. A trial that failed counts as an error of one length of the robot." }
        figure { (drawing) figcaption { (CAPTION) } }
        @for (title, group) in groups(rows) {
            h2 { (title) }
            @let grid = table(&group);
            div.wide-table { table {
                thead { tr { @for name in &grid.header { th { (name) } } } }
                tbody { @for row in &grid.rows { tr { @for (name, cell) in grid.header.iter().zip(row) { td data-label=(name) { (cell) } } } } }
            } }
        }
    };
    Ok(document("Board of the league", &content))
}

/// Dots with intervals, a heading for each table.
fn draw(rows: &[BoardRow], width: f64) -> Canvas {
    let (mut names, mut dots) = (Vec::new(), Vec::new());
    let at = |share: f64| (100.0 * share.max(LEAST_SHARE)).log10();
    for (title, group) in groups(rows) {
        names.push(DotRow::Heading(title));
        for row in group {
            let place = names.len();
            names.push(DotRow::Named(row.name.clone(), 1));
            let thin = (row.low_95.is_finite() && row.high_95.is_finite())
                .then(|| [at(row.low_95), at(row.high_95)]);
            if row.floor > 0.0 {
                dots.push(Dot {
                    hollow: true,
                    ..Dot::new(place, 0, at(row.floor), Marker::Diamond, GREY)
                });
            }
            dots.push(Dot {
                thin,
                words: format!("{:.2}", 100.0 * row.error),
                ..Dot::new(place, 0, at(row.error), Marker::Circle, INK)
            });
        }
    }
    let ends = rows.iter().flat_map(|row| [row.low_95, row.high_95, row.error, row.floor]);
    let ends = ends.filter(|value| value.is_finite()).map(|share| 100.0 * share.max(LEAST_SHARE));
    let x = Axis::log("error (% of length)", ends, 100.0);
    let chart = DotChart {
        rows: names,
        lane_height: 15.0,
        min_panel: 110.0,
        aside: 40.0,
        panels: vec![DotPanel::new("", x, dots)],
    };
    let mut canvas = Canvas::new(width, TALL);
    canvas.height = chart.draw(&mut canvas, 24.0).round();
    canvas
}

/// Errors below this share of the length stand at the edge of the axis.
const LEAST_SHARE: f64 = 1e-4;
