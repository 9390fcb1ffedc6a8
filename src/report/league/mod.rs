//! The board of a league: tables, a figure, and a page of both.

use maud::{Markup, html};

use super::drawing::{Axis, Canvas, Dot, DotChart, DotPanel, DotRow};
use super::html::{self, document, figure};
use super::page::markup::MarkdownTable;
use super::style::{GREY, INK, Marker, TALL};
use super::{Artifact, ReportError, captioned, csv, text};
use crate::rows::league::{ALL, ANSWERS, BoardRow, SHARE_NOT_NAMED};

/// Name of the figures in errors.
const NAME: &str = "board";

/// The files of a board: CSV, JSON, Markdown, a page, and a figure for each track.
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
    for track in tracks(rows) {
        let whole = families(track)[0];
        let stem = format!("board_{}_{}", whole[0].track, whole[0].season);
        files.extend(captioned(NAME, &stem, &caption(whole), |width| draw(whole, width))?);
    }
    Ok(files)
}

/// What ranks and dashes mean.
const RANKS: &str = "A rank is one more than the number of submissions whose 95 % interval lies wholly below: a wide \
     interval can have a better rank than a smaller mean. A dash: a submission without all modes or speeds, or a single \
     robot. A trial that failed counts as an error of one length of the robot. Tick: median time of an answer; policies \
     of this program have none. False alarm: nothing is missing; missed detection: nothing was named; wrong isolation: \
     another effect was named.";

/// What a figure shows.
fn caption(family: &[BoardRow]) -> String {
    let BoardRow { track, season, robots, .. } = &family[0];
    let mut words = format!(
        "Track {track}, season {season}, robots {robots}: {}, mean and 95 % interval over robots.",
        measure(family)
    );
    if family.iter().any(|row| row.floor.is_finite()) {
        words += " Grey, hollow: the best of the controllers that know the hidden effects.";
    }
    if cells(family).len() > 1 {
        words += " Without a dot: a submission without this mode or speed.";
    }
    words
}

/// What the numbers of a track are.
fn measure(track: &[BoardRow]) -> String {
    format!("{} (%)", track[0].measure)
}

/// The rows of each track and season; they follow one another.
fn tracks(rows: &[BoardRow]) -> Vec<&[BoardRow]> {
    rows.chunk_by(|one, next| (&one.track, &one.season) == (&next.track, &next.season)).collect()
}

/// The rows of all robots of a track, and of each family.
fn families(track: &[BoardRow]) -> Vec<&[BoardRow]> {
    track.chunk_by(|one, next| one.robots == next.robots).collect()
}

/// The rows of all modes or speeds, and of each.
fn cells(family: &[BoardRow]) -> Vec<&[BoardRow]> {
    family.chunk_by(|one, next| one.cell == next.cell).collect()
}

/// Names of the submissions, those of the first cell in their order, then the others.
fn names(family: &[BoardRow]) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for row in family {
        if !names.contains(&row.name.as_str()) {
            names.push(&row.name);
        }
    }
    names
}

/// A share in per cent.
fn percent(share: f64) -> String {
    if share.is_finite() { format!("{:.2}", 100.0 * share) } else { "–".to_owned() }
}

/// The rank of a row; none without an interval.
fn rank(row: Option<&BoardRow>) -> String {
    let ranked = row.filter(|row| row.low_95.is_finite());
    ranked.map_or("–".to_owned(), |row| row.rank.to_string())
}

/// The error of a row with its interval, in per cent.
fn with_interval(row: &BoardRow) -> String {
    let [error, low_95, high_95] = [row.error, row.low_95, row.high_95].map(percent);
    if row.low_95.is_finite() { format!("{error} [{low_95},\u{a0}{high_95}]") } else { error }
}

/// A table: names, ranks, errors over all modes or speeds and of each.
fn table(family: &[BoardRow]) -> MarkdownTable {
    let cells = cells(family);
    // Where no submission has all modes, none has an error over them.
    let has_whole = cells.len() == 1 || cells.iter().any(|cell| cell[0].cell == ALL);
    let (first, parts) = cells.split_at(usize::from(has_whole));
    // What no submission has, has no column.
    let has_floor = first.iter().flat_map(|cell| *cell).any(|row| row.floor.is_finite());
    let has_samples = family.iter().any(|row| row.samples > 0);
    let has_tick = family.iter().any(|row| row.tick_ms.is_finite());
    let first = first.first().copied().unwrap_or_default();
    let rows = names(family).into_iter().filter_map(|name| {
        let own: Vec<&BoardRow> = family.iter().filter(|row| row.name == name).collect();
        let whole = first.iter().find(|row| row.name == name);
        let counted = if whole.is_some() { own[..1].to_vec() } else { own.clone() };
        let any = own.first()?;
        let mut cells =
            vec![name.to_owned(), rank(whole), whole.map_or("–".to_owned(), with_interval)];
        cells.extend(parts.iter().map(|part| {
            percent(part.iter().find(|row| row.name == name).map_or(f64::NAN, |row| row.error))
        }));
        if has_floor {
            cells.push(percent(whole.map_or(f64::NAN, |row| row.floor)));
        }
        if has_samples {
            cells.push(any.samples.to_string());
        }
        if has_tick {
            let tick_ms = any.tick_ms.is_finite().then(|| format!("{:.2}", any.tick_ms));
            cells.push(tick_ms.unwrap_or_else(|| "–".to_owned()));
        }
        cells.push(failed(&counted));
        Some(cells)
    });
    let parts: String = parts.iter().map(|part| format!("{}, % | ", part[0].cell)).collect();
    let is_share = family[0].measure == SHARE_NOT_NAMED;
    let [error, failures] = if is_share { ["Not named", "Why"] } else { ["Error", "Failed"] };
    let further =
        [(has_floor, "Floor, % | "), (has_samples, "Samples | "), (has_tick, "Tick, ms | ")];
    let further: String = further.iter().filter(|(has, _)| *has).map(|(_, name)| *name).collect();
    let header = format!("Submission | Rank | {error}, % | {parts}{further}{failures}");
    MarkdownTable::new(&header, rows)
}

/// How many of the trials of some rows failed, and why.
fn failed(rows: &[&BoardRow]) -> String {
    let count = |value: fn(&BoardRow) -> u64| rows.iter().map(|row| value(row)).sum::<u64>();
    let mut words = format!("{} of {}", count(|row| row.failed), count(|row| row.trials));
    for row in rows.iter().filter(|row| !row.failures.is_empty()) {
        let cell = if rows.len() > 1 { format!("{}: ", row.cell) } else { String::new() };
        words += &format!("; {cell}{}", row.failures);
    }
    words
}

fn markdown(rows: &[BoardRow]) -> String {
    let mut out = String::from("# Board of the league\n");
    for track in tracks(rows) {
        let [first, ..] = track else { continue };
        out += &format!("\n## {}, {}: {}\n", first.track, first.season, measure(track));
        for family in families(track) {
            out += &format!("\nRobots: {}\n\n{}", family[0].robots, table(family).markdown());
        }
    }
    out + "\n" + RANKS + "\n"
}

fn page(rows: &[BoardRow]) -> Result<String, ReportError> {
    let mut content = html! {
        h1 { "Board of the league" }
        p { (RANKS) }
    };
    for track in tracks(rows) {
        content.0 += &html! { h2 { (track[0].track) ", " (track[0].season) } }.0;
        for (place, family) in families(track).into_iter().enumerate() {
            let drawing = figure(NAME, |width| Some(draw(family, width)))?;
            let shown = html! {
                figure { (drawing) figcaption { (caption(family)) } }
                (page_table(family))
            };
            content.0 += &html! {
                @if place == 0 { h3 { "Robots: " (family[0].robots) } (shown) }
                @else { details { summary { "Robots: " (family[0].robots) } (shown) } }
            }
            .0;
        }
    }
    Ok(document("Board of the league", &content))
}

fn page_table(rows: &[BoardRow]) -> Markup {
    let grid = table(rows);
    let header: Vec<&str> = grid.header.iter().map(String::as_str).collect();
    let cells = |row: &Vec<String>| row.iter().map(|cell| html! { (cell) }).collect();
    html::table(&header, &grid.rows.iter().map(cells).collect::<Vec<_>>())
}

/// A row for each submission, a panel for all modes or speeds and for each.
fn draw(family: &[BoardRow], width: f64) -> Canvas {
    let names = names(family);
    let ends = || {
        let values = family.iter().flat_map(|row| [row.low_95, row.high_95, row.error, row.floor]);
        values.filter(|value| value.is_finite()).map(|share| 100.0 * share)
    };
    // A share reaches zero.
    let is_share = family[0].measure == SHARE_NOT_NAMED;
    let (x, at): (Axis, fn(f64) -> f64) = if is_share {
        (Axis::exact(&measure(family), 0.0, 100.0, 4), |share| 100.0 * share)
    } else {
        let place = |share: f64| (100.0 * share.max(LEAST)).log10();
        (Axis::log(&measure(family), ends().map(|value| value.max(100.0 * LEAST)), 130.0), place)
    };
    let panels = cells(family).into_iter().map(|cell| {
        let mut dots = Vec::new();
        for row in cell {
            let place = names.iter().position(|name| *name == row.name).unwrap_or_default();
            if row.floor.is_finite() {
                let floor = Dot::new(place, 0, at(row.floor), Marker::Diamond, GREY);
                dots.push(Dot { hollow: true, ..floor });
            }
            let has_interval = row.low_95.is_finite() && row.high_95.is_finite();
            dots.push(Dot {
                thin: has_interval.then(|| [at(row.low_95), at(row.high_95)]),
                // Numbers keep clear of a dot at the end of the axis.
                words: format!("{}{:.2}", if is_share { "\u{a0}" } else { "" }, 100.0 * row.error),
                ..Dot::new(place, 0, at(row.error), Marker::Circle, INK)
            });
        }
        let title = match cell[0].cell.as_str() {
            ALL => "mean of all",
            ANSWERS => "",
            cell => cell,
        };
        DotPanel::new(&title.replace('_', " "), x.clone(), dots)
    });
    let chart = DotChart {
        panels: panels.collect(),
        rows: names.iter().map(|name| DotRow::Named((*name).to_owned(), 1)).collect(),
        lane_height: 15.0,
        min_panel: 90.0,
        aside: 34.0,
    };
    let mut canvas = Canvas::new(width, TALL);
    canvas.height = chart.draw(&mut canvas, 24.0).round();
    canvas
}

/// Errors below this share of the length stand at the edge of the axis: ends of intervals.
const LEAST: f64 = 1e-3;
