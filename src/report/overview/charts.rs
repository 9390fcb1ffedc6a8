//! What the charts of the page show, as data for the program that draws them.

use maud::{Markup, html};
use serde::Serialize;
use std::collections::BTreeMap;

use super::tables::EmbeddedTable;
use crate::policies;
use crate::report::style::{capitalised, mode_title, policy_label, training_label};

/// A chart of one table.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Chart {
    /// How it is drawn.
    pub(super) kind: ChartKind,
    /// Number of its table.
    pub(super) table: usize,
    /// What is shown, for a reader who does not see it.
    pub(super) title: String,
    /// Horizontal axis.
    pub(super) x: AxisColumn,
    /// Vertical axis, where there is one.
    pub(super) y: Option<AxisColumn>,
    /// Columns of the ends of an interval around `x` (dots) or `y` (lines).
    pub(super) interval: Option<[&'static str; 2]>,
    /// Columns whose values name a line of dots.
    pub(super) category: Vec<String>,
    /// Column whose values are told apart by colour.
    pub(super) series: Option<&'static str>,
    /// Columns of which the reader chooses one value, with the value at the start.
    pub(super) facets: Vec<(&'static str, String)>,
    /// In place of the column of `x`: several columns with their names, a series each.
    pub(super) columns: Vec<(&'static str, &'static str)>,
    /// With `columns`, the column of `x` for each of them, where it differs.
    pub(super) x_columns: Vec<&'static str>,
    /// Whether the points of a series are joined in the order of the rows.
    pub(super) joined: bool,
    /// Column of the paper's number.
    pub(super) paper: Option<&'static str>,
}

/// How a chart is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum ChartKind {
    /// A mark with an interval for every category and series.
    #[default]
    Dots,
    /// All values of every category.
    Strips,
    /// A line with a band for every series.
    Lines,
    /// Points of a plane.
    Points,
}

/// An axis.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct AxisColumn {
    /// Its column.
    pub(super) column: &'static str,
    /// What it shows, with the unit.
    pub(super) label: &'static str,
    /// Factor of the numbers, such as 1000 for metres in millimetres.
    pub(super) scale: f64,
    /// Whether it is logarithmic.
    pub(super) log: bool,
    /// Whether it shows zero.
    pub(super) zero: bool,
}

impl AxisColumn {
    /// Metres as millimetres, from zero.
    pub(super) fn millimetres(column: &'static str, label: &'static str) -> AxisColumn {
        AxisColumn { column, label, scale: 1e3, log: false, zero: true }
    }

    /// A number as it is.
    pub(super) fn plain(column: &'static str, label: &'static str) -> AxisColumn {
        AxisColumn { column, label, scale: 1.0, log: false, zero: false }
    }

    /// The axis with a logarithmic scale.
    pub(super) fn log(self) -> AxisColumn {
        AxisColumn { log: true, zero: false, ..self }
    }
}

/// The tables and charts of the page.
#[derive(Clone, Debug, Default)]
pub(super) struct PageData {
    tables: Vec<EmbeddedTable>,
    charts: Vec<Chart>,
}

impl PageData {
    /// Adds a table and gives its number.
    pub(super) fn add(&mut self, table: EmbeddedTable) -> usize {
        self.tables.push(table);
        self.tables.len() - 1
    }

    /// Adds a chart and gives its place on the page.
    pub(super) fn chart(&mut self, chart: Chart, caption: &str) -> Markup {
        let file = self.tables.get(chart.table).map_or("", |table| table.file.as_str()).to_owned();
        let (number, title) = (self.charts.len(), chart.title.clone());
        self.charts.push(chart);
        html! {
            figure .chart data-chart=(number) aria-label=(title) {
                h3 { (title) }
                noscript { p .note { "This chart needs JavaScript. Its numbers are in " code { (file) } "." } }
                figcaption { (caption) " Numbers: " code { (file) } "." }
            }
        }
    }

    /// Everything as JSON that may stand in a page.
    pub(super) fn to_json(&self) -> String {
        #[derive(Serialize)]
        struct CarriedData<'a> {
            labels: BTreeMap<&'a str, String>,
            tables: Vec<CarriedTable<'a>>,
            charts: &'a [Chart],
        }
        #[derive(Serialize)]
        struct CarriedTable<'a> {
            file: &'a str,
            columns: BTreeMap<&'a str, &'a super::tables::Column>,
        }
        let tables = self.tables.iter().map(|table| CarriedTable {
            file: &table.file,
            columns: table.columns.iter().map(|(name, column)| (name.as_str(), column)).collect(),
        });
        let data = CarriedData { labels: labels(), tables: tables.collect(), charts: &self.charts };
        // Text of a table cannot end the script.
        serde_json::to_string(&data).unwrap_or_default().replace("</", "<\\/")
    }
}

/// What was measured in a row of a sweep, and what stands in place of a training.
const TASKS: [(&str, &str); 5] = [
    ("reach", "goal reaching"),
    ("response", "trials of fixed duration"),
    ("track", "path"),
    ("gp", "cross-validation of the Gaussian process"),
    ("any", "independent of training"),
];

/// The names of policies, modes, trainings and tasks in figures.
fn labels() -> BTreeMap<&'static str, String> {
    let mut labels: BTreeMap<&str, String> = policies::REGISTRY
        .iter()
        .map(|entry| (entry.name, policy_label(entry.name).to_owned()))
        .collect();
    for mode in ["open", "closed", "closed_load"] {
        labels.insert(mode, mode_title(mode));
    }
    for training in ["paper", "converged"] {
        labels.insert(training, training_label(training));
    }
    for (name, shown) in TASKS {
        labels.insert(name, shown.to_owned());
    }
    // π stays as it is.
    let shown = |label: String| if !label.starts_with('π') { capitalised(&label) } else { label };
    labels.into_iter().map(|(name, label)| (name, shown(label))).collect()
}
