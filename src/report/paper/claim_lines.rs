//! The paper's claims as lines of a table: one line a claim, with the verdict of every kind of
//! training.

use crate::report::drawing::signed;
use crate::report::style::{ANY_TRAINING, training_label};
use crate::rows::experiment::ClaimRow;

/// A claim with its verdicts.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ClaimLine<'a> {
    /// Experiment, name, statement and quantity are those of every row.
    pub(crate) rows: Vec<&'a ClaimRow>,
}

/// The claims in the order of their first rows.
pub(crate) fn claim_lines(rows: &[ClaimRow]) -> Vec<ClaimLine<'_>> {
    let mut lines: Vec<ClaimLine> = Vec::new();
    for row in rows {
        let same = |line: &&mut ClaimLine| {
            let first = line.first();
            (&first.experiment, &first.claim) == (&row.experiment, &row.claim)
        };
        match lines.iter_mut().find(same) {
            Some(line) => line.rows.push(row),
            None => lines.push(ClaimLine { rows: vec![row] }),
        }
    }
    lines
}

impl ClaimLine<'_> {
    /// The row of the first kind of training.
    pub(crate) fn first(&self) -> &ClaimRow {
        self.rows[0]
    }

    /// The range in which the claim holds, in words.
    pub(crate) fn holds_if(&self) -> String {
        let row = self.first();
        let unit = Unit::of(&row.unit);
        match (row.holds_above.is_finite(), row.holds_below.is_finite()) {
            (true, true) => {
                let [low, high] = [row.holds_above, row.holds_below].map(|limit| unit.limit(limit));
                format!("{low} to {high} {}", unit.name)
            }
            (true, false) => format!("> {} {}", unit.limit(row.holds_above), unit.name),
            (false, true) => format!("< {} {}", unit.limit(row.holds_below), unit.name),
            (false, false) => "–".to_owned(),
        }
    }
}

/// A unit as it is shown: metres as millimetres.
struct Unit {
    name: String,
    scale: f64,
}

impl Unit {
    fn of(unit: &str) -> Unit {
        if unit == "m" || unit.starts_with("m/") {
            Unit { name: format!("m{unit}"), scale: 1e3 }
        } else {
            Unit { name: unit.to_owned(), scale: 1.0 }
        }
    }

    /// A limit, which a spec states in few digits.
    fn limit(&self, value: f64) -> String {
        let text = signed(self.scale * value, 3);
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    }
}

/// The numbers of a claim as text, with a common number of decimals (three significant digits of
/// our largest value); metres as millimetres.
pub(crate) struct ClaimCells {
    /// What the paper reports.
    pub(crate) paper: String,
    /// What this reproduction finds.
    pub(crate) ours: String,
    /// Its interval.
    pub(crate) interval: Option<String>,
    /// The unit of all.
    pub(crate) unit: String,
}

impl ClaimCells {
    /// The cells of a row.
    pub(crate) fn of(row: &ClaimRow) -> ClaimCells {
        let unit = Unit::of(&row.unit);
        let scale = unit.scale;
        let finite =
            [row.ours, row.low_95, row.high_95].into_iter().filter(|value| value.is_finite());
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
            unit: unit.name,
        }
    }

    /// Our number with its interval.
    pub(crate) fn ours_with_interval(&self) -> String {
        match &self.interval {
            Some(interval) => format!("{} {interval}", self.ours),
            None => self.ours.clone(),
        }
    }
}

/// A verdict as a sentence: experiment, claim, kind of training, number, range and verdict.
pub fn claim_sentence(row: &ClaimRow) -> String {
    let cells = ClaimCells::of(row);
    let holds_if = ClaimLine { rows: vec![row] }.holds_if();
    let networks = if row.training == ANY_TRAINING {
        String::new()
    } else {
        format!(", {}", training_label(&row.training))
    };
    format!(
        "{} ({}{networks}): {} {}, holds if {holds_if}: {}",
        row.claim,
        row.experiment,
        cells.ours_with_interval(),
        cells.unit,
        row.verdict
    )
}
