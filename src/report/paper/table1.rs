//! Table I: goal-reaching error of every policy in open loop, in closed loop and with a load,
//! beside the paper's numbers; as Markdown, LaTeX, CSV and a picture.

use super::printed;
use crate::policies::{self, OutsidePolicies};
use crate::report::cells::MODES;
use crate::report::drawing::{
    Axis, Canvas, Dot, DotChart, DotPanel, DotRow, LegendEntry, MIN_PANEL, legend,
};
use crate::report::order::trainings;
use crate::report::page::markup::{MarkdownTable, latex};
use crate::report::style::{
    BLUE, Colour, GREEN, INK, Marker, NARROW, ORANGE, TALL, policies_in_order, policy_label,
    policy_latex, policy_markdown,
};
use crate::report::{Artifact, Figure, Published, ReportError, csv, text};
use crate::rows::experiment::ReachSummaryRow;

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "table1",
    about: "Table I: goal-reaching error of every policy, ours and the paper's",
    render,
};

const HEADINGS: [&str; 3] = ["Open-loop", "Closed-loop", "Closed-loop with load"];

/// One line of the table under a controller: the paper's or ours.
struct Source<'a> {
    label: String,
    colour: Colour,
    marker: Marker,
    /// None for the paper.
    training: Option<&'a str>,
}

/// Mean, standard deviation and, where there are seeds enough, the mean's interval; metres.
struct TableEntry {
    mean_m: f64,
    sd_m: f64,
    interval_m: Option<[f64; 2]>,
}

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    let trials = &published.trials;
    FIGURE.needs("trials.csv", trials.is_empty() && published.reached.is_empty())?;
    let summary = published.reach_summary(trials);
    one_size(&summary)?;
    let table = ControllerTable {
        sources: sources(published, &summary),
        shown: policies_in_order(summary.iter().map(|row| row.cell.policy.as_str())),
        summary: &summary,
        outside: &published.context.outside,
    };
    FIGURE.files(
        vec![
            csv("summary.csv", &summary)?,
            text("table1.md", table.markdown()),
            text("table1.tex", table.tex()),
        ],
        &table.caption(),
        |width| table.draw(width),
    )
}

/// What the Markdown, the LaTeX and the picture show.
struct ControllerTable<'a> {
    summary: &'a [ReachSummaryRow],
    sources: Vec<Source<'a>>,
    shown: Vec<&'a str>,
    outside: &'a OutsidePolicies,
}

/// A cell of the table averages over one size of data only.
fn one_size(summary: &[ReachSummaryRow]) -> Result<(), ReportError> {
    let cell = |row: &ReachSummaryRow| {
        (row.training.clone(), row.cell.policy.clone(), row.cell.mode.clone())
    };
    let Some(pair) = summary.windows(2).find(|pair| cell(&pair[0]) == cell(&pair[1])) else {
        return Ok(());
    };
    let size = |row: &ReachSummaryRow| format!("{} + {}", row.cell.gp_points, row.cell.real_points);
    let found = format!(
        "policy {} with {} and {} real points",
        pair[0].cell.policy,
        size(&pair[0]),
        size(&pair[1])
    );
    Err(ReportError::Mixed { figure: FIGURE.name, found, expected: "size of data for a policy" })
}

fn sources<'a>(published: &Published, summary: &'a [ReachSummaryRow]) -> Vec<Source<'a>> {
    let looks = [(BLUE, Marker::Circle), (GREEN, Marker::Diamond), (ORANGE, Marker::Triangle)];
    let paper =
        Source { label: "paper".to_owned(), colour: INK, marker: Marker::Square, training: None };
    let names = trainings(summary.iter().map(|row| row.training.as_str()));
    let ours = names.into_iter().enumerate().map(|(index, name)| {
        let (colour, marker) = looks[index % looks.len()];
        let label = format!("ours, {}", published.training_label(name));
        Source { label, colour, marker, training: Some(name) }
    });
    // The paper's numbers are about its robot.
    published.context.is_paper_robot.then_some(paper).into_iter().chain(ours).collect()
}

impl ControllerTable<'_> {
    fn entry(&self, source: &Source, policy: &str, mode: &str) -> Option<TableEntry> {
        let Some(training) = source.training else {
            let paper = printed::table_1(policy, mode)?;
            return Some(TableEntry { mean_m: paper.mean_m, sd_m: paper.sd_m, interval_m: None });
        };
        let cell = |row: &&ReachSummaryRow| {
            row.training == training && row.cell.policy == policy && row.cell.mode == mode
        };
        let row = self.summary.iter().find(cell).filter(|row| row.trials > 0)?;
        let interval_m = row.low_95_m.is_finite().then_some([row.low_95_m, row.high_95_m]);
        Some(TableEntry { mean_m: row.mean_m, sd_m: row.sd_m, interval_m })
    }

    /// `mean(SD)` in metres as the paper prints it.
    fn printed(&self, source: &Source, policy: &str, mode: &str) -> String {
        match self.entry(source, policy, mode) {
            Some(entry) => format!("{}({})", decimals(entry.mean_m), decimals(entry.sd_m)),
            None => self.absent(policy, mode).to_owned(),
        }
    }

    /// "N/A" where the policy does not run in that mode, a dash where it could and was not run.
    fn absent(&self, policy: &str, mode: &str) -> &'static str {
        let entry = policies::find_with(policy, self.outside);
        let closed_loop_only = entry.is_some_and(|entry| entry.closed_loop_only);
        if mode == "open" && closed_loop_only { "N/A" } else { "–" }
    }
}

/// Five decimals as the paper prints, six where a printed number has six.
fn decimals(value_m: f64) -> String {
    let five = format!("{value_m:.5}");
    let six = format!("{value_m:.6}");
    let exact = six.parse() == Ok(value_m);
    if exact && !six.ends_with('0') { six } else { five }
}

fn caption(summary: &[ReachSummaryRow]) -> String {
    let seeds = summary.iter().map(|row| row.seeds).max().unwrap_or(0);
    let max_trials = summary.iter().map(|row| row.trials).max().unwrap_or(0);
    let failed: u64 = summary.iter().map(|row| row.failed).sum();
    let times = if seeds == 1 { "once" } else { &format!("{seeds} times") };
    let failures = if failed == 0 {
        String::new()
    } else {
        format!("; {failed} trials without an error value are excluded")
    };
    format!(
        "Goal-reaching error in metres, mean(standard deviation over targets); the whole \
         experiment, including data and training, was run {times}, {max_trials} trials per \
         cell{failures}."
    )
}

impl ControllerTable<'_> {
    fn markdown(&self) -> String {
        let mut grid = MarkdownTable::default();
        grid.header.extend(["Controller".to_owned(), String::new()]);
        grid.header.extend(HEADINGS.map(|heading| format!("{heading} (m)")));
        for &policy in &self.shown {
            for (line, source) in self.sources.iter().enumerate() {
                let name = if line == 0 {
                    format!("**{}**", policy_markdown(policy))
                } else {
                    String::new()
                };
                let cells = MODES.map(|mode| self.printed(source, policy, mode));
                grid.rows.push([name, source.label.clone()].into_iter().chain(cells).collect());
            }
        }
        format!("{}\n{}\n", grid.markdown(), caption(self.summary))
    }

    fn tex(&self) -> String {
        let mut out = String::from(
            "% needs booktabs\n\\begin{table}\n\\caption{Performance comparison for goal reaching for \
         different policies}\n\\begin{tabular*}{\\columnwidth}{@{\\extracolsep{\\fill}} l \
         ccc}\n\\toprule\nController & \\multicolumn{3}{c}{Goal Reaching Error (m)} \
         \\\\\n\\cmidrule{2-4}\n",
        );
        out.push_str(&format!(" & {} \\\\\n", HEADINGS.join(" & ")));
        for source in &self.sources {
            out.push_str(&format!(
                "\\midrule\n\\multicolumn{{4}}{{l}}{{\\emph{{{}}}}} \\\\\n",
                latex(&source.label)
            ));
            for &policy in &self.shown {
                let name = policy_latex(policy);
                let cells = MODES.map(|mode| self.printed(source, policy, mode));
                out.push_str(&format!("{name} & {} \\\\\n", cells.join(" & ").replace('–', "--")));
            }
        }
        out.push_str("\\bottomrule\n\\end{tabular*}\n\n\\smallskip\\scriptsize\n");
        out.push_str(&latex(&caption(self.summary)));
        for entry in self
            .shown
            .iter()
            .filter_map(|policy| policies::find(policy))
            .filter(|entry| !entry.footnote.is_empty())
        {
            out.push_str(&format!(" {}: {}", entry.label.latex, entry.footnote));
        }
        out.push('\n');
        out.push_str("\\end{table}\n");
        out
    }

    /// What the picture shows.
    fn caption(&self) -> String {
        let paper = if self.sources.iter().any(|source| source.training.is_none()) {
            ", ours and the paper’s"
        } else {
            ""
        };
        let seeds = self.summary.iter().map(|row| row.seeds).max().unwrap_or(0);
        let trials = self.summary.iter().map(|row| row.trials).max().unwrap_or(0);
        format!(
            "Goal-reaching error of each controller in open loop, in closed loop and with a load, in \
             mm{paper}. Marks are means over {trials} trials in {seeds} repetitions; thin lines: one \
             standard deviation over targets; thick lines: 95 % interval of the mean. N/A: the \
             controller does not run in open loop; –: not run."
        )
    }

    fn draw(&self, width: f64) -> Canvas {
        let ControllerTable { sources, shown, .. } = self;
        let mut canvas = Canvas::new(width, TALL);
        let keys: Vec<(LegendEntry, &str)> = sources
            .iter()
            .map(|source| {
                (
                    LegendEntry::Marker(source.marker, source.colour, source.training.is_none()),
                    source.label.as_str(),
                )
            })
            .collect();
        let base = legend(&mut canvas, [10.0, 16.0], width - 8.0, &keys);
        let every = || {
            let cells =
                MODES.iter().flat_map(|mode| shown.iter().map(move |policy| (policy, mode)));
            cells.flat_map(|(policy, mode)| {
                sources.iter().filter_map(move |source| self.entry(source, policy, mode))
            })
        };
        let ends = every().flat_map(|entry| [entry.mean_m, entry.mean_m + entry.sd_m]);
        let wanted = if width < NARROW { 2 } else { 4 };
        let x = Axis::from_zero("error (mm)", ends.map(|end_m| 1e3 * end_m), wanted);
        let panels = MODES.iter().zip(HEADINGS).map(|(mode, heading)| DotPanel {
            title: if width < NARROW {
                heading.replace("Closed-loop with", "With")
            } else {
                heading.to_owned()
            },
            x: x.clone(),
            dots: self.dots(mode),
            joined: false,
            goals: Vec::new(),
        });
        let lanes = sources.len();
        let chart = DotChart {
            rows: shown
                .iter()
                .map(|policy| DotRow::Named(policy_label(policy).to_owned(), lanes))
                .collect(),
            lane_height: if shown.len() > 6 { 11.0 } else { 15.0 },
            min_panel: MIN_PANEL,
            aside: 0.0,
            panels: panels.collect(),
        };
        canvas.height = chart.draw(&mut canvas, base + 30.0).round();
        canvas
    }

    /// The dots and intervals of one mode.
    fn dots(&self, mode: &str) -> Vec<Dot> {
        let sources = self.sources.iter().enumerate();
        let cells = sources.flat_map(|(lane, source)| {
            self.shown.iter().enumerate().map(move |(row, policy)| (lane, source, row, policy))
        });
        let dot = |(lane, source, row, policy): (usize, &Source, usize, &&str)| {
            let empty = Dot::new(row, lane, f64::NAN, source.marker, source.colour);
            let Some(TableEntry { mean_m, sd_m, interval_m }) = self.entry(source, policy, mode)
            else {
                return Dot { words: self.absent(policy, mode).to_owned(), ..empty };
            };
            Dot {
                value: 1e3 * mean_m,
                hollow: source.training.is_none(),
                thin: Some([mean_m - sd_m, mean_m + sd_m].map(|end_m| 1e3 * end_m)),
                thick: interval_m.map(|ends| ends.map(|end_m| 1e3 * end_m)),
                ..empty
            }
        };
        cells.map(dot).collect()
    }
}
