//! The benchmark's figures as a table in Markdown: a line for each figure, a column for each part
//! of the cases.

use super::measures::{SummaryRow, is_ratio};
use crate::report::discovery::format::NONE;
use crate::report::order::distinct;
use crate::report::page::markup::MarkdownTable;

/// The table, with a line on how to read it.
pub(crate) fn markdown(rows: &[SummaryRow]) -> String {
    let parts = distinct(rows.iter().map(|row| row.part.as_str()));
    let mut grid = MarkdownTable {
        header: ["Figure", "To reach"].map(str::to_owned).to_vec(),
        rows: Vec::new(),
    };
    grid.header.extend(
        parts
            .iter()
            .map(|part| if *part == "all" { "All cases".to_owned() } else { (*part).to_owned() }),
    );
    for measure in distinct(rows.iter().map(|row| row.measure.as_str())) {
        let here = |part: &str| rows.iter().find(|row| row.measure == measure && row.part == part);
        let goal =
            rows.iter().find(|row| row.measure == measure).map_or("", |row| row.goal.as_str());
        let mut cells = vec![
            measure.to_owned(),
            if goal.is_empty() { NONE.to_owned() } else { goal.to_owned() },
        ];
        cells.extend(parts.iter().map(|part| here(part).map_or_else(|| NONE.to_owned(), shown)));
        grid.rows.push(cells);
    }
    format!(
        "{}\nIn brackets: 95 % interval (Wilson’s for shares, order statistics for medians) and \
         number of cases. Bold: reached.\n",
        grid.markdown()
    )
}

/// `**96 %** [93, 98] (297)`.
pub(crate) fn shown(row: &SummaryRow) -> String {
    let value = plain(row);
    let value = if row.verdict == "met" { format!("**{value}**") } else { value };
    format!("{value}{} ({})", interval(row), row.cases)
}

/// The value alone.
pub(crate) fn plain(row: &SummaryRow) -> String {
    if is_ratio(&row.measure) {
        format!("{:.2}", row.value)
    } else {
        format!("{} %", percent(row.value))
    }
}

/// ` [93, 98]`; nothing where there is none.
pub(crate) fn interval(row: &SummaryRow) -> String {
    let number =
        |value: f64| if is_ratio(&row.measure) { format!("{value:.2}") } else { percent(value) };
    match [row.low_95, row.high_95] {
        [low, high] if low.is_finite() && high.is_finite() => {
            format!(" [{}, {}]", number(low), number(high))
        }
        _ => String::new(),
    }
}

/// A share in percent: one decimal near the ends, where it matters.
pub(crate) fn percent(share: f64) -> String {
    let value = 100.0 * share;
    let near_end = (value > 0.0 && value < 9.95) || (value > 90.05 && value < 99.95);
    crate::report::drawing::signed(value, usize::from(near_end))
}
