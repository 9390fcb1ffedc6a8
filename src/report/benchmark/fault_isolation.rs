//! `discover` and methods of comparison in the terms of fault isolation: true detections, false
//! alarms, and the mean probability that is given to what is hidden.

use serde::Serialize;

use super::cases::{alarmed, in_catalogue};
use super::share::{IntervalEstimate, median, wilson, wilson_mean};
use super::table::percent;
use crate::data::findings::CaseRow;
use crate::report::discovery::answer::closed;
use crate::report::discovery::format::NONE;
use crate::report::drawing::{Axis, Canvas, Panel, Text, TextAlign};
use crate::report::page::markup::MarkdownTable;
use crate::report::style::{GREY, HALF_CAP, LOOKS, SMALL, TEXT};

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

/// Width of the figure: that of one column, so that it can be read on a phone.
const WIDTH: f64 = 400.0;
const LEFT: f64 = 126.0;
const RIGHT: f64 = 106.0;
const TOP: f64 = 24.0;
/// Height of a method's row, and of what stands between two panels.
const ROW: f64 = 17.0;
const BETWEEN: f64 = 44.0;

/// Draws detection, false alarms and isolation of single effects, a panel each, one below the
/// other.
pub(crate) fn draw(scores: &[MethodScore]) -> Canvas {
    let panels = [
        (DETECTION, "true detection (%): more is better"),
        (FALSE_ALARMS, "false alarms (%): fewer is better"),
        (SINGLES, "probability given to the hidden effect (%): more is better"),
    ];
    let high = ROW * METHODS.len() as f64;
    let mut canvas = Canvas::new(WIDTH, TOP + (high + BETWEEN) * panels.len() as f64 - 16.0);
    for (index, (measure, title)) in panels.into_iter().enumerate() {
        let top = TOP + (high + BETWEEN) * index as f64;
        canvas.text(Text::new(title, [10.0, top - 9.0], TEXT, TextAlign::Left).bold());
        let panel = canvas.panel(Panel {
            corner: [LEFT, top],
            size: [WIDTH - LEFT - RIGHT, high],
            x: Axis::exact("", 0.0, 100.0, 4),
            y: Axis::bare_to(1.0),
            title: String::new(),
        });
        for (turn, (method, look)) in METHODS.iter().zip(LOOKS).enumerate() {
            let y = top + ROW * (turn as f64 + 0.5);
            let baseline = y + HALF_CAP * TEXT;
            let name = Text::new(method.name, [LEFT - 7.0, baseline], TEXT, TextAlign::Right);
            canvas.text(name);
            let at = [WIDTH - RIGHT + 7.0, baseline];
            let Some(score) = find(scores, method.name, measure) else {
                canvas.text(Text::new("names nothing", at, SMALL, TextAlign::Left).colour(GREY));
                continue;
            };
            let place = |share: f64| [panel.at(100.0 * share.clamp(0.0, 1.0), 0.0)[0], y];
            canvas.line(&[place(score.low_95), place(score.high_95)], 2.0, look.colour, &[]);
            canvas.marker(place(score.value), look.marker, 4.2, look.colour, false);
            canvas.text(Text::new(shown(score), at, SMALL, TextAlign::Left));
        }
    }
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
