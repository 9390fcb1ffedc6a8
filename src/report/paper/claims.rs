//! The verdicts of the paper's claims: a table in Markdown and a figure of our values over the
//! paper's.

use super::claim_lines::{ClaimCells, ClaimLine, claim_lines};
use crate::report::drawing::{
    Axis, Canvas, LegendEntry, Panel, Text, TextAlign, legend, text_width,
};
use crate::report::page::markup::MarkdownTable;
use crate::report::style::{
    Colour, DASHED, GREEN, GREY, HAIR, HALF_CAP, INK, MARKER, Marker, PAGE_WIDTH, SMALL, VERMILION,
    WHITE, claim_label, training_short,
};
use crate::report::{Artifact, Figure, Published, ReportError, text};
use crate::rows::experiment::ClaimRow;

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "claims",
    about: "The paper’s claims: its figure, ours with an interval, and the verdict",
    render,
};

const ROW_HEIGHT: f64 = 17.0;
/// Range of the ratio of ours to the paper's; ratios outside are drawn as arrows at the edge.
const RATIO_RANGE: [f64; 2] = [-1.0, 3.0];

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    let claims = &published.claims;
    FIGURE.needs("claims.csv", claims.is_empty())?;
    FIGURE.files(vec![text("claims.md", markdown(claims))], &draw(claims))
}

/// One table an experiment: a line a claim, with the verdict of every kind of training.
fn markdown(claims: &[ClaimRow]) -> String {
    let lines = claim_lines(claims);
    let mut experiments: Vec<&str> =
        lines.iter().map(|line| line.first().experiment.as_str()).collect();
    experiments.dedup();
    let count = |verdict| {
        format!("{} {verdict}", claims.iter().filter(|row| row.verdict == verdict).count())
    };
    let counts = ["reproduced", "not reproduced", "undecided"].map(count).join(", ");
    let mut text = format!(
        "Verdicts: {counts}. A claim is reproduced where the 95 % interval of its quantity over \
         the seeds lies inside the range of “holds if”, not reproduced where it lies outside, and \
         undecided where it crosses a limit.\n"
    );
    for experiment in experiments {
        let rows = lines
            .iter()
            .filter(|line| line.first().experiment == experiment)
            .flat_map(markdown_rows);
        let header = "Claim | Quantity | Holds if | Paper | Networks | Ours, 95 % interval | \
                      Seeds | Verdict";
        let table = MarkdownTable::new(header, rows).markdown();
        text.push_str(&format!("\n## {experiment}\n\n{table}"));
    }
    text
}

/// The rows of a claim; what all share stands in the first.
fn markdown_rows(line: &ClaimLine) -> Vec<Vec<String>> {
    let row = |(index, row): (usize, &&ClaimRow)| {
        let cells = ClaimCells::of(row);
        let shared = [
            format!("“{}” (`{}`)", row.statement, row.claim),
            row.quantity.clone(),
            line.holds_if(),
            if row.paper.is_finite() {
                format!("{} {}", cells.paper, cells.unit)
            } else {
                cells.paper.clone()
            },
        ];
        let shared = shared.map(|text| if index == 0 { text } else { String::new() });
        let ours = format!("{} {}", cells.ours_with_interval(), cells.unit);
        let verdict = format!("**{}**", row.verdict);
        let own = [training_short(&row.training).to_owned(), ours, row.seeds.to_string(), verdict];
        [shared, own].concat()
    };
    line.rows.iter().enumerate().map(row).collect()
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
    let high = ROW_HEIGHT * claims.len() as f64;
    let top = 58.0;
    let mut canvas = Canvas::new(PAGE_WIDTH, (top + high + 44.0).round());
    let keys = ["reproduced", "not reproduced", "undecided"].map(|verdict| {
        let (colour, marker, hollow) = look(verdict);
        (LegendEntry::Marker(marker, colour, hollow), verdict)
    });
    legend(&mut canvas, [236.0, 18.0], PAGE_WIDTH, &keys);
    let axis = Axis::exact("ours / paper", RATIO_RANGE[0], RATIO_RANGE[1], 4);
    let rows = Axis::bare_to(claims.len() as f64);
    let panel = canvas.panel(Panel {
        corner: [236.0, top],
        size: [208.0, high],
        x: axis,
        y: rows,
        title: String::new(),
    });
    let columns = [(462.0, "paper"), (510.0, "ours [95 % interval]"), (652.0, "unit")];
    for (x, name) in columns {
        canvas.text(Text::new(name, [x, top - 8.0], SMALL, TextAlign::Left).bold());
    }
    panel.line(&mut canvas, &[[0.0, 0.0], [0.0, claims.len() as f64]], GREY, DASHED, HAIR);
    panel.line(&mut canvas, &[[1.0, 0.0], [1.0, claims.len() as f64]], INK, &[], HAIR);
    canvas.text(Text::new("paper", [panel.at(1.0, 0.0)[0], top - 8.0], SMALL, TextAlign::Centre));
    canvas.text(Text::new("nothing", [panel.at(0.0, 0.0)[0], top - 8.0], SMALL, TextAlign::Centre));
    // With a long name, all names are set smaller to stay in their column.
    let widest = claims
        .iter()
        .map(|row| text_width(&claim_label(&row.claim), SMALL, false))
        .fold(148.0, f64::max);
    let size = SMALL * 148.0 / widest;
    for (index, row) in claims.iter().enumerate() {
        let y = top + ROW_HEIGHT * (index as f64 + 0.5);
        claim(&mut canvas, &panel, row, y);
        let first = index == 0 || claims[index - 1].claim != row.claim;
        let base = y + HALF_CAP * SMALL;
        let shown = ClaimCells::of(row);
        let ours_with_interval = shown.ours_with_interval();
        if first {
            canvas.text(Text::new(claim_label(&row.claim), [10.0, base], size, TextAlign::Left));
        }
        canvas.text(
            Text::new(training_short(&row.training), [228.0, base], 8.6, TextAlign::Right)
                .colour(GREY),
        );
        canvas.text(Text::new(shown.paper, [columns[0].0, base], SMALL, TextAlign::Left));
        canvas.text(
            Text::new(ours_with_interval, [columns[1].0, base], SMALL, TextAlign::Left)
                .colour(look(&row.verdict).0),
        );
        canvas.text(Text::new(shown.unit, [columns[2].0, base], SMALL, TextAlign::Left));
        if first && index > 0 {
            let edge = y - ROW_HEIGHT / 2.0;
            canvas.line(
                &[[10.0, edge], [PAGE_WIDTH - 10.0, edge]],
                HAIR,
                crate::report::style::GRID,
                &[],
            );
        }
    }
    canvas
}

/// One row of the figure: ours over the paper's, with its interval.
fn claim(canvas: &mut Canvas, panel: &Panel, row: &ClaimRow, y: f64) {
    let (colour, marker, hollow) = look(&row.verdict);
    let place = |value: f64| {
        let ratio = value / row.paper;
        ratio
            .is_finite()
            .then(|| [panel.at(ratio.clamp(RATIO_RANGE[0], RATIO_RANGE[1]), 0.0)[0], y])
    };
    let Some(middle) = place(row.ours) else {
        let label = if row.paper == 0.0 { "paper: 0, no ratio" } else { "no figure in the paper" };
        let at = panel.at(0.08, 0.0)[0];
        canvas.rectangle(
            [at - 2.0, y - 6.0],
            [at + 2.0 + text_width(label, 8.6, false), y + 6.0],
            WHITE,
            1.0,
        );
        canvas
            .text(Text::new(label, [at, y + HALF_CAP * SMALL], 8.6, TextAlign::Left).colour(GREY));
        return;
    };
    if let (Some(low), Some(high)) = (place(row.low_95), place(row.high_95)) {
        canvas.line(&[low, high], 1.8, colour, &[]);
    }
    let ratio = row.ours / row.paper;
    if !(RATIO_RANGE[0]..=RATIO_RANGE[1]).contains(&ratio) {
        let way = if ratio > RATIO_RANGE[1] { 1.0 } else { -1.0 };
        let tip = [middle[0] + 5.0 * way, y];
        canvas.area(
            vec![tip, [tip[0] - 9.0 * way, y - 4.5], [tip[0] - 9.0 * way, y + 4.5]],
            colour,
            1.0,
        );
        return;
    }
    canvas.marker(middle, marker, MARKER, colour, hollow);
}
