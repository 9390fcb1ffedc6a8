//! The paper's claims and what became of them: a table in Markdown and a picture of ours against the paper's.

use super::axes::{Axis, Panel};
use super::canvas::{Align, Canvas, Text};
use super::legend::{Key, legend};
use super::markup::Grid;
use super::style::{Colour, DASHED, GREEN, GREY, HAIR, INK, MARKER, Marker, PAGE_WIDTH, SMALL, VERMILION};
use super::{Artifact, Figure, Published, ReportError, pictures, text};
use crate::data::rows::ClaimRow;

/// Registry entry.
pub const FIGURE: Figure =
    Figure {
        name: "claims", about: "The paper’s claims: its figure, ours with an interval, and the verdict", render
    };

const ROW: f64 = 17.0;
/// Ratios of ours to the paper's beyond these are drawn as arrows at the edge.
const REACH: [f64; 2] = [-1.0, 3.0];

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    let claims = &published.claims;
    if claims.is_empty() {
        return Err(ReportError::NoRows { figure: FIGURE.name, needs: "claims.csv" });
    }
    let mut files = vec![text("claims.md", markdown(claims))];
    files.extend(pictures(FIGURE.name, FIGURE.name, &draw(claims))?);
    Ok(files)
}

/// Three significant digits, without a tail of zeros that nobody measured.
fn number(value: f64) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = (2.0 - value.abs().log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.digits$}").replace('-', "−")
}

fn interval(row: &ClaimRow) -> String {
    if row.low_95.is_finite() && row.high_95.is_finite() {
        format!("[{}, {}]", number(row.low_95), number(row.high_95))
    } else {
        "–".to_owned()
    }
}

fn markdown(claims: &[ClaimRow]) -> String {
    let header = ["Claim", "Training", "Paper", "Ours", "95 % interval", "Unit", "Seeds", "Verdict"];
    let mut grid = Grid { header: header.map(str::to_owned).to_vec(), rows: Vec::new() };
    for row in claims {
        grid.rows.push(vec![
            row.statement.clone(),
            row.training.clone(),
            number(row.paper),
            number(row.ours),
            interval(row),
            row.unit.clone(),
            row.seeds.to_string(),
            format!("**{}**", row.verdict),
        ]);
    }
    let mut counts: Vec<String> = Vec::new();
    for verdict in ["reproduced", "not reproduced", "undecided"] {
        counts.push(format!("{} {verdict}", claims.iter().filter(|row| row.verdict == verdict).count()));
    }
    format!("{}\n{}.\n", grid.markdown(), counts.join(", "))
}

/// Colour, marker and whether it is hollow.
fn look(verdict: &str) -> (Colour, Marker, bool) {
    match verdict {
        "reproduced" => (GREEN, Marker::Circle, false),
        "not reproduced" => (VERMILION, Marker::Square, false),
        _ => (GREY, Marker::Diamond, true),
    }
}

fn draw(claims: &[ClaimRow]) -> Canvas {
    let high = ROW * claims.len() as f64;
    let top = 58.0;
    let mut canvas = Canvas::new(PAGE_WIDTH, (top + high + 44.0).round());
    let keys = ["reproduced", "not reproduced", "undecided"].map(|verdict| {
        let (colour, marker, hollow) = look(verdict);
        (Key::Marker(marker, colour, hollow), verdict)
    });
    legend(&mut canvas, [200.0, 18.0], PAGE_WIDTH, &keys);
    let axis = Axis::exact("ours / paper", REACH[0], REACH[1], 4);
    let rows = Axis { label: String::new(), low: 0.0, high: claims.len() as f64, ticks: Vec::new() };
    let panel = Panel { corner: [200.0, top], size: [230.0, high], x: axis, y: rows, title: String::new() };
    panel.draw(&mut canvas);
    let columns = [(448.0, "paper"), (502.0, "ours [95 % interval]"), (640.0, "unit")];
    for (x, name) in columns {
        canvas.text(Text::new(name, [x, top - 8.0], SMALL, Align::Left).bold());
    }
    panel.line(&mut canvas, &[[0.0, 0.0], [0.0, claims.len() as f64]], GREY, DASHED, HAIR);
    panel.line(&mut canvas, &[[1.0, 0.0], [1.0, claims.len() as f64]], INK, &[], HAIR);
    canvas.text(Text::new("paper", [panel.at(1.0, 0.0)[0], top - 8.0], SMALL, Align::Centre));
    canvas.text(Text::new("nothing", [panel.at(0.0, 0.0)[0], top - 8.0], SMALL, Align::Centre));
    for (index, row) in claims.iter().enumerate() {
        let y = top + ROW * (index as f64 + 0.5);
        claim(&mut canvas, &panel, row, y);
        let first = index == 0 || claims[index - 1].claim != row.claim;
        let name = if first { row.claim.replace('_', " ") } else { String::new() };
        let base = y + 0.36 * SMALL;
        canvas.text(Text::new(name, [10.0, base], SMALL, Align::Left));
        canvas.text(Text::new(&row.training, [192.0, base], 8.6, Align::Right).colour(GREY));
        canvas.text(Text::new(number(row.paper), [columns[0].0, base], SMALL, Align::Left));
        let ours = format!("{} {}", number(row.ours), interval(row)).replace(" –", "");
        canvas.text(Text::new(ours, [columns[1].0, base], SMALL, Align::Left).colour(look(&row.verdict).0));
        canvas.text(Text::new(&row.unit, [columns[2].0, base], SMALL, Align::Left));
        if first && index > 0 {
            let edge = y - ROW / 2.0;
            canvas.line(&[[10.0, edge], [PAGE_WIDTH - 10.0, edge]], HAIR, super::style::GRID, &[]);
        }
    }
    canvas
}

/// One line of the picture: ours over the paper's, with its interval.
fn claim(canvas: &mut Canvas, panel: &Panel, row: &ClaimRow, y: f64) {
    let (colour, marker, hollow) = look(&row.verdict);
    let place = |value: f64| {
        let ratio = value / row.paper;
        ratio.is_finite().then(|| [panel.at(ratio.clamp(REACH[0], REACH[1]), 0.0)[0], y])
    };
    let Some(middle) = place(row.ours) else {
        let at = [panel.at(REACH[0], 0.0)[0] + 6.0, y + 0.36 * SMALL];
        canvas.text(Text::new("no figure in the paper", at, 8.6, Align::Left).colour(GREY));
        return;
    };
    if let (Some(low), Some(high)) = (place(row.low_95), place(row.high_95)) {
        canvas.line(&[low, high], 1.8, colour, &[]);
    }
    let ratio = row.ours / row.paper;
    if ratio < REACH[0] || ratio > REACH[1] {
        let way = if ratio > REACH[1] { 1.0 } else { -1.0 };
        let tip = [middle[0] + 5.0 * way, y];
        canvas.area(vec![tip, [tip[0] - 9.0 * way, y - 4.5], [tip[0] - 9.0 * way, y + 4.5]], colour, 1.0);
        return;
    }
    canvas.marker(middle, marker, MARKER, colour, hollow);
}
