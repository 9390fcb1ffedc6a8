//! The verdicts of the paper's claims: a table in Markdown, and a figure of the statements in groups
//! with a mark for each verdict.

use crate::report::drawing::{Canvas, LegendEntry, Text, TextAlign, legend, lines, signed};
use crate::report::order::{distinct, trainings};
use crate::report::page::markup::MarkdownTable;
use crate::report::style::{
    Colour, GREEN, GREY, GRID, HAIR, HALF_CAP, MARKER, Marker, NARROW, SMALL, TALL, TEXT,
    VERMILION, capitalised, claim_sentence, training_short,
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

/// The numbers of a claim as text, with a common number of decimals (three significant digits of
/// our largest value); metres as millimetres.
struct ClaimCells {
    paper: String,
    ours: String,
    interval: Option<String>,
    unit: String,
}

fn shown(row: &ClaimRow) -> ClaimCells {
    let metres = row.unit == "m" || row.unit.starts_with("m/");
    let (scale, unit) =
        if metres { (1e3, format!("m{}", row.unit)) } else { (1.0, row.unit.clone()) };
    let finite = [row.ours, row.low_95, row.high_95].into_iter().filter(|value| value.is_finite());
    let largest = finite.map(|value| (scale * value).abs()).fold(0.0, f64::max);
    let number = |value: f64, largest: f64| {
        let digits = if largest > 0.0 {
            (2.0 - largest.log10().floor()).clamp(0.0, 6.0) as usize
        } else {
            0
        };
        if value.is_finite() { signed(scale * value, digits) } else { "–".to_owned() }
    };
    let has_interval = row.low_95.is_finite() && row.high_95.is_finite();
    ClaimCells {
        paper: number(row.paper, (scale * row.paper).abs()),
        ours: number(row.ours, largest),
        interval: has_interval.then(|| {
            format!("[{}, {}]", number(row.low_95, largest), number(row.high_95, largest))
        }),
        unit,
    }
}

fn markdown(claims: &[ClaimRow]) -> String {
    let line = |row: &ClaimRow| {
        let shown = shown(row);
        vec![
            row.statement.clone(),
            row.experiment.clone(),
            training_short(&row.training).to_owned(),
            shown.paper,
            shown.ours,
            shown.interval.unwrap_or_else(|| "–".to_owned()),
            shown.unit,
            row.seeds.to_string(),
            format!("**{}**", row.verdict),
        ]
    };
    let header =
        "Claim | Experiment | Networks | Paper | Ours | 95 % interval | Unit | Seeds | Verdict";
    let table = MarkdownTable::new(header, claims.iter().map(line)).markdown();
    format!("{table}\n{}.\n", count(claims))
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

/// The verdicts on one statement, by training.
struct Claim<'a> {
    group: String,
    statement: &'a str,
    rows: Vec<&'a ClaimRow>,
}

impl<'a> Claim<'a> {
    /// The claims in the order of their groups.
    fn all(claims: &'a [ClaimRow]) -> Vec<Claim<'a>> {
        let mut all: Vec<Claim> = Vec::new();
        for row in claims {
            let same = |claim: &&mut Claim| {
                claim.rows[0].claim == row.claim && claim.rows[0].experiment == row.experiment
            };
            if let Some(claim) = all.iter_mut().find(same) {
                claim.rows.push(row);
                continue;
            }
            let heading = GROUPS.iter().find(|(name, _)| *name == row.experiment);
            let (group, statement) = match row.statement.strip_prefix(VALUES[0]) {
                Some(value) => (VALUES[1].to_owned(), value),
                None => (
                    heading.map_or(row.experiment.clone(), |(_, words)| (*words).to_owned()),
                    row.statement.as_str(),
                ),
            };
            all.push(Claim { group, statement, rows: vec![row] });
        }
        let headings = distinct(all.iter().map(|claim| claim.group.clone()));
        let place = |claim: &Claim| {
            let known = GROUPS.iter().position(|(_, words)| *words == claim.group);
            (known.unwrap_or(GROUPS.len()), headings.iter().position(|name| *name == claim.group))
        };
        all.sort_by_key(place);
        all
    }

    /// The statement as a sentence, with the unit of its number and the paper's.
    fn sentence(&self) -> String {
        let shown = shown(self.rows[0]);
        let paper = if self.rows[0].paper.is_finite() {
            format!("paper: {} {}", shown.paper, shown.unit)
        } else {
            shown.unit
        };
        format!("{} ({paper})", claim_sentence(self.statement))
    }
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
    let of_networks = claims.iter().map(|row| row.training.as_str()).filter(|name| *name != "any");
    let mut trainings = trainings(of_networks);
    if trainings.is_empty() {
        trainings.push("any");
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
    let mut group = String::new();
    for claim in Claim::all(claims) {
        if claim.group != group {
            group.clone_from(&claim.group);
            y += 10.0;
            for line in lines(&group, TEXT, 0.88 * width) {
                y += TEXT + 2.0;
                canvas.text(Text::new(line, [10.0, y], TEXT, TextAlign::Left).bold());
            }
            y += 5.0;
        }
        y = layout.claim(&mut canvas, &claim, y);
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
    fn claim(&self, canvas: &mut Canvas, claim: &Claim, top: f64) -> f64 {
        let right = canvas.width - 10.0;
        canvas.line(&[[10.0, top], [right, top]], HAIR, GRID, &[]);
        let pitch = SMALL + 3.0;
        let mut base = top + SMALL + 2.0;
        let first = base;
        for (index, line) in lines(&claim.sentence(), SMALL, self.room).into_iter().enumerate() {
            base = first + pitch * index as f64;
            canvas.text(Text::new(line, [10.0, base], SMALL, TextAlign::Left));
        }
        let numbers = if self.stacked { base + pitch } else { first };
        for row in &claim.rows {
            let (colour, marker, hollow) = look(&row.verdict);
            let shown = shown(row);
            let words = format!("{} {}", shown.ours, shown.interval.unwrap_or_default());
            // Where no network takes part, the number is that of every training.
            let columns = self.trainings.iter().zip(&self.columns);
            for (_, x) in
                columns.filter(|(name, _)| **name == row.training || row.training == "any")
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
