//! The verdicts of the paper's claims: a table in Markdown, and a figure of the statements in groups
//! with a mark for each verdict.

use super::claim_lines::{ClaimCells, ClaimLine, claim_lines};
use crate::report::drawing::{Canvas, LegendEntry, Text, TextAlign, legend, lines};
use crate::report::order::{distinct, trainings};
use crate::report::page::markup::MarkdownTable;
use crate::report::style::{
    ANY_TRAINING, Colour, GREEN, GREY, GRID, HAIR, HALF_CAP, MARKER, Marker, NARROW, SMALL, TALL,
    TEXT, VERMILION, capitalised, claim_words, training_short,
};
use crate::report::{Artifact, Figure, Published, ReportError, text};
use crate::rows::experiment::ClaimRow;

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "claims",
    about: "The paper’s claims: its figure, ours with an interval, and the verdict",
    render,
};

/// Width of a number with its interval.
const NUMBERS_WIDTH: f64 = 148.0;

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    let claims = &published.claims;
    FIGURE.needs("claims.csv", claims.is_empty())?;
    let tables = vec![text("claims.md", markdown(claims))];
    FIGURE.files(tables, &caption(claims), |width| draw(claims, width))
}

/// One table an experiment: a line a claim, with the verdict of every kind of training.
fn markdown(claims: &[ClaimRow]) -> String {
    let lines = claim_lines(claims);
    let mut experiments: Vec<&str> =
        lines.iter().map(|line| line.first().experiment.as_str()).collect();
    experiments.dedup();
    let counts = count(claims);
    let mut text = format!(
        "Verdicts: {counts}. A claim is reproduced if the 95 % interval of its quantity over the \
         seeds lies inside the range of “holds if”, not reproduced if it lies outside, and \
         undecided if it crosses a limit.\n"
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

/// How many claims have each verdict.
fn count(claims: &[ClaimRow]) -> String {
    let count = |verdict| {
        format!("{} {verdict}", claims.iter().filter(|row| row.verdict == verdict).count())
    };
    ["reproduced", "not reproduced", "undecided"].map(count).join(", ")
}

/// Colour, marker and whether it is hollow.
fn look(verdict: &str) -> (Colour, Marker, bool) {
    match verdict {
        "reproduced" => (GREEN, Marker::Circle, false),
        "not reproduced" => (VERMILION, Marker::Square, false),
        _ => (GREY, Marker::Diamond, true),
    }
}

/// The parts of a paper that experiments are about.
const GROUPS: [(&str, &str); 4] = [
    ("table1", "Table I: comparisons of controllers, and errors of networks"),
    ("fig5", "Fig. 5: difference between the model and the “real” robot"),
    ("fig6", "Fig. 6: error against the number of real points"),
    ("fig8", "Fig. 8: path tracking"),
];
/// How the statements of the table's numbers begin, and the heading above them.
const VALUES: [&str; 2] = ["Table I, ", "Table I: each number"];

/// The heading above a claim, and its statement.
fn group<'a>(line: &'a ClaimLine) -> (&'a str, &'a str) {
    let row = line.first();
    if let Some(value) = row.statement.strip_prefix(VALUES[0]) {
        return (VALUES[1], value);
    }
    let known = GROUPS.iter().find(|(name, _)| *name == row.experiment);
    (known.map_or(&row.experiment, |(_, words)| words), &row.statement)
}

/// The statement as a sentence, with the range in which it holds and the paper's number.
fn sentence(line: &ClaimLine) -> String {
    let cells = ClaimCells::of(line.first());
    let paper = if line.first().paper.is_finite() {
        format!("; paper: {} {}", cells.paper, cells.unit)
    } else {
        String::new()
    };
    let words = claim_words(group(line).1);
    format!("{words} (holds if {}{paper})", line.holds_if())
}

fn caption(claims: &[ClaimRow]) -> String {
    let seeds = claims.iter().map(|row| row.seeds).max().unwrap_or(0);
    let counts = count(claims);
    format!(
        "Verdicts on the paper’s statements, by the paper’s table or figure, for networks stopped at \
         the paper’s errors and networks trained to convergence: {counts}. Numbers are our means \
         over {seeds} repetitions with their 95 % intervals; of a comparison the number is the \
         difference. A statement is reproduced if the whole interval lies in the range in which it \
         holds, and undecided if a part does."
    )
}

fn draw(claims: &[ClaimRow], width: f64) -> Canvas {
    let of_networks =
        claims.iter().map(|row| row.training.as_str()).filter(|name| *name != ANY_TRAINING);
    let mut trainings = trainings(of_networks);
    if trainings.is_empty() {
        trainings.push(ANY_TRAINING);
    }
    let mut canvas = Canvas::new(width, TALL);
    let keys = ["reproduced", "not reproduced", "undecided"].map(|verdict| {
        let (colour, marker, hollow) = look(verdict);
        (LegendEntry::Marker(marker, colour, hollow), verdict)
    });
    let mut y = legend(&mut canvas, [10.0, 16.0], width - 8.0, &keys) + 20.0;
    let layout = ClaimLayout::new(width, trainings);
    for (name, column) in layout.trainings.iter().zip(&layout.columns) {
        let heading = capitalised(training_short(name));
        canvas.text(Text::new(heading, [*column, y], SMALL, TextAlign::Left).bold());
    }
    let mut all = claim_lines(claims);
    let headings = distinct(all.iter().map(|line| group(line).0.to_owned()));
    all.sort_by_key(|line| {
        let heading = group(line).0;
        let known = GROUPS.iter().position(|(_, words)| *words == heading);
        (known.unwrap_or(GROUPS.len()), headings.iter().position(|name| name == heading))
    });
    let mut heading = String::new();
    for claim in &all {
        if group(claim).0 != heading {
            heading = group(claim).0.to_owned();
            y += 10.0;
            for line in lines(&heading, TEXT, 0.88 * width) {
                y += TEXT + 2.0;
                canvas.text(Text::new(line, [10.0, y], TEXT, TextAlign::Left).bold());
            }
            y += 5.0;
        }
        y = layout.claim(&mut canvas, claim, y);
    }
    canvas.height = (y + 8.0).round();
    canvas
}

/// Where sentences and numbers stand.
struct ClaimLayout<'a> {
    trainings: Vec<&'a str>,
    /// Left edge of the numbers of each training.
    columns: Vec<f64>,
    /// Width of a line of a sentence.
    room: f64,
    /// Whether the numbers stand below the sentence.
    stacked: bool,
}

impl<'a> ClaimLayout<'a> {
    fn new(width: f64, trainings: Vec<&'a str>) -> ClaimLayout<'a> {
        let stacked = width < NARROW;
        let pitch = if stacked { 0.5 * (width - 24.0) } else { NUMBERS_WIDTH };
        let count = trainings.len().max(1) as f64;
        let first = if stacked { 24.0 } else { width - 4.0 - pitch * count };
        let columns = (0..trainings.len()).map(|index| first + pitch * index as f64).collect();
        let room = if stacked { width - 20.0 } else { first - 24.0 };
        ClaimLayout { trainings, columns, room, stacked }
    }

    /// Draws one claim below `top`; returns where it ends.
    fn claim(&self, canvas: &mut Canvas, claim: &ClaimLine, top: f64) -> f64 {
        let right = canvas.width - 10.0;
        canvas.line(&[[10.0, top], [right, top]], HAIR, GRID, &[]);
        let pitch = SMALL + 3.0;
        let mut base = top + SMALL + 2.0;
        let first = base;
        for (index, line) in lines(&sentence(claim), SMALL, self.room).into_iter().enumerate() {
            base = first + pitch * index as f64;
            canvas.text(Text::new(line, [10.0, base], SMALL, TextAlign::Left));
        }
        let numbers = if self.stacked { base + pitch } else { first };
        for row in &claim.rows {
            let (colour, marker, hollow) = look(&row.verdict);
            let words = ClaimCells::of(row).ours_with_interval();
            // Where no network takes part, the number is that of every training.
            let columns = self.trainings.iter().zip(&self.columns);
            for (_, x) in
                columns.filter(|(name, _)| **name == row.training || row.training == ANY_TRAINING)
            {
                let at = [x + 4.0, numbers - HALF_CAP * SMALL];
                canvas.marker(at, marker, MARKER, colour, hollow);
                let text = Text::new(&words, [x + 13.0, numbers], SMALL, TextAlign::Left);
                canvas.text(text.colour(colour));
            }
        }
        base.max(numbers) + 5.0
    }
}
