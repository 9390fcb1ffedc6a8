//! `discover` and methods of comparison in the terms of fault isolation: true detections, false
//! alarms, and the mean probability that is given to what is hidden.

use serde::Serialize;

use super::cases::{alarmed, in_catalogue};
use super::share::{IntervalEstimate, median, wilson, wilson_mean};
use super::table::percent;
use crate::data::findings::CaseRow;
use crate::report::discovery::answer::closed;
use crate::report::discovery::format::NONE;
use crate::report::drawing::{Axis, Canvas, Dot, DotChart, DotPanel, DotRow};
use crate::report::page::markup::MarkdownTable;
use crate::report::style::{GREY, LOOKS, Look, TALL};

/// One figure of one method (`fault_isolation.csv`).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct MethodScore {
    pub(crate) method: String,
    /// What is measured.
    pub(crate) measure: String,
    /// Cases behind it.
    pub(crate) cases: u64,
    pub(crate) value: f64,
    pub(crate) low_95: f64,
    pub(crate) high_95: f64,
}

/// What a method says of a case.
struct Method {
    name: &'static str,
    detects: fn(&CaseRow) -> bool,
    /// Probability given to what is hidden; none of a method that names nothing.
    isolation: Option<fn(&CaseRow) -> f64>,
    after_m: fn(&CaseRow) -> f64,
}

const METHODS: [Method; 5] = [
    Method {
        name: "discover",
        detects: alarmed,
        isolation: Some(|case| case.isolation),
        after_m: |case| case.after_m,
    },
    Method {
        name: "sparse regression",
        detects: |case| !case.sparse_answer.is_empty(),
        isolation: Some(|case| case.sparse_isolation),
        after_m: |case| case.sparse_m,
    },
    Method {
        name: "all effects, ridge",
        detects: |case| case.ridge_detects,
        isolation: Some(|case| case.ridge_isolation),
        after_m: |case| case.ridge_m,
    },
    Method {
        name: "polynomials",
        detects: |case| case.library_detects,
        isolation: None,
        after_m: |case| case.library_m,
    },
    Method {
        name: "Gaussian process",
        detects: |case| case.gp_detects,
        isolation: None,
        after_m: |case| case.gp_m,
    },
];

const DETECTION: &str = "true detection";
const FALSE_ALARMS: &str = "false alarms";
const SINGLES: &str = "isolation, single effects";
const PAIRS: &str = "isolation, pairs";
const GAP_CLOSED: &str = "gap closed";
const MEASURES: [&str; 5] = [DETECTION, FALSE_ALARMS, SINGLES, PAIRS, GAP_CLOSED];

/// Every figure of every method over the cases that all methods were asked about; none in older
/// tables.
pub(crate) fn scores(cases: &[CaseRow]) -> Vec<MethodScore> {
    let asked: Vec<&CaseRow> = cases.iter().filter(|case| case.library_m.is_finite()).collect();
    METHODS
        .iter()
        .flat_map(|method| MEASURES.iter().filter_map(|measure| method.score(measure, &asked)))
        .collect()
}

impl Method {
    fn score(&self, measure: &str, cases: &[&CaseRow]) -> Option<MethodScore> {
        let (estimate, count) = match measure {
            DETECTION => self.detected(cases, |case| case.group != "nothing")?,
            FALSE_ALARMS => self.detected(cases, |case| case.group == "nothing")?,
            SINGLES => self.isolated(cases, "single")?,
            PAIRS => self.isolated(cases, "pair")?,
            _ => {
                let gaps = cases.iter().filter(|case| in_catalogue(case));
                let closed = gaps
                    .filter_map(|case| closed(case.before_m, (self.after_m)(case), case.floor_m));
                let closed: Vec<f64> = closed.collect();
                (median(&closed)?, closed.len())
            }
        };
        let IntervalEstimate { value, low_95, high_95 } = estimate;
        let (method, measure) = (self.name.to_owned(), measure.to_owned());
        Some(MethodScore { method, measure, cases: count as u64, value, low_95, high_95 })
    }

    fn detected(
        &self,
        cases: &[&CaseRow],
        about: fn(&CaseRow) -> bool,
    ) -> Option<(IntervalEstimate, usize)> {
        let relevant: Vec<&&CaseRow> = cases.iter().filter(|case| about(case)).collect();
        let hits = relevant.iter().filter(|case| (self.detects)(case)).count();
        Some((wilson(hits as u64, relevant.len() as u64)?, relevant.len()))
    }

    /// Mean probability given to what is hidden, where something is detected.
    fn isolated(&self, cases: &[&CaseRow], group: &str) -> Option<(IntervalEstimate, usize)> {
        let isolation = self.isolation?;
        let detected = cases.iter().filter(|case| case.group == group && (self.detects)(case));
        let given: Vec<f64> =
            detected.map(|case| isolation(case)).filter(|share| share.is_finite()).collect();
        Some((wilson_mean(given.iter().sum(), given.len() as u64)?, given.len()))
    }
}

/// The table: a line a method, a column a figure.
pub(crate) fn markdown(scores: &[MethodScore]) -> String {
    let cell = |method: &str, measure: &str| {
        let found = find(scores, method, measure);
        found.map_or_else(|| NONE.to_owned(), |score| format!("{} ({})", shown(score), score.cases))
    };
    let rows = METHODS.iter().map(|method| {
        let cells = MEASURES.iter().map(|measure| cell(method.name, measure));
        std::iter::once(method.name.to_owned()).chain(cells).collect()
    });
    let grid = MarkdownTable::new(&format!("Method | {}", MEASURES.join(" | ")), rows);
    format!(
        "{}\nIn brackets: 95 % interval (Wilson’s; of medians, order statistics) and number of \
         cases. Isolation: mean probability given to what is hidden, where something is detected. \
         Gap closed: median over single effects and pairs.\n",
        grid.markdown()
    )
}

fn find<'a>(scores: &'a [MethodScore], method: &str, measure: &str) -> Option<&'a MethodScore> {
    scores.iter().find(|score| score.method == method && score.measure == measure)
}

/// `98 % [93, 99]`.
fn shown(score: &MethodScore) -> String {
    let MethodScore { value, low_95, high_95, .. } = score;
    let value = format!("{} %", percent(*value));
    if low_95.is_finite() && high_95.is_finite() {
        return format!("{value} [{}, {}]", percent(*low_95), percent(*high_95));
    }
    value
}

/// What the picture shows.
pub(crate) const CAPTION: &str = "Discovery and four methods of comparison in the terms of fault \
                                  isolation, in % with 95 % intervals: cases with a hidden effect \
                                  in which the method reports one (true detection), cases without \
                                  one in which it reports one (false alarm), and the mean \
                                  probability of the hidden effect in its reports.";

/// Draws detection, false alarms and isolation of single effects, a panel each.
pub(crate) fn draw(scores: &[MethodScore], width: f64) -> Canvas {
    let panels = [
        (DETECTION, "True detection", "% (more is better)"),
        (FALSE_ALARMS, "False alarms", "% (fewer is better)"),
        (SINGLES, "Probability of the truth", "% (more is better)"),
    ];
    let panel = |(measure, title, axis): (&str, &str, &str)| {
        let dot = |(row, (method, look)): (usize, (&Method, Look))| {
            let Some(score) = find(scores, method.name, measure) else {
                let words = "names nothing".to_owned();
                return Dot { words, ..Dot::new(row, 0, f64::NAN, look.marker, GREY) };
            };
            let percent = |share: f64| (100.0 * share).clamp(0.0, 100.0);
            Dot {
                thin: Some([score.low_95, score.high_95].map(percent)),
                words: shown(score),
                ..Dot::new(row, 0, percent(score.value), look.marker, look.colour)
            }
        };
        let dots = METHODS.iter().zip(LOOKS).enumerate().map(dot).collect();
        DotPanel::new(title, Axis::exact(axis, 0.0, 100.0, 4), dots)
    };
    let chart = DotChart {
        rows: METHODS.iter().map(|method| DotRow::Named(method.name.to_owned(), 1)).collect(),
        lane_height: 15.0,
        min_panel: 80.0,
        aside: 108.0,
        panels: panels.into_iter().map(panel).collect(),
    };
    let mut canvas = Canvas::new(width, TALL);
    canvas.height = chart.draw(&mut canvas, 24.0).round();
    canvas
}

#[cfg(test)]
mod tests {
    use super::*;

    fn score(method: &str, measure: &str, value: f64) -> MethodScore {
        let (method, measure) = (method.to_owned(), measure.to_owned());
        MethodScore { method, measure, cases: 4, value, low_95: f64::NAN, high_95: f64::NAN }
    }

    #[test]
    fn what_names_nothing_has_no_isolation() {
        let table =
            markdown(&[score("discover", SINGLES, 0.975), score("polynomials", DETECTION, 1.0)]);
        assert!(table.contains("| discover | – | – | 97.5 % (4) | – | – |"), "{table}");
        assert!(table.contains("| polynomials | 100 % (4) | – | – | – | – |"), "{table}");
    }
}
