//! Table I beside the paper's, with all errors.

use maud::{Markup, html};
use std::path::Path;

use super::charts::{AxisColumn, Chart, ChartKind, PageData};
use super::tables::{EmbeddedTable, published_columns};
use crate::data::DataError;
use crate::report::published_rows;
use crate::report::style::{mode_title, policies_in_order, policy_label, training_label};
use crate::rows::experiment::ReachSummaryRow;

const MODES: [&str; 3] = ["open", "closed", "closed_load"];
const TRAININGS: [&str; 2] = ["paper", "converged"];

/// The section; nothing without `table1/summary.csv`.
///
/// # Errors
/// [`DataError`] for a table that cannot be read.
pub(super) fn section(results: &Path, data: &mut PageData) -> Result<Markup, DataError> {
    let rows: Vec<ReachSummaryRow> = published_rows(&results.join("table1"))?;
    let policies = policies_in_order(rows.iter().map(|row| row.cell.policy.as_str()));
    if policies.is_empty() {
        return Ok(Markup::default());
    }
    let strips = strips(results, data)?;
    Ok(html! {
        p {
            "Distance from the target at the end of a trial in mm: mean, and in brackets the standard deviation \
             over all trials of all repetitions together. The claims about Table I use the mean of the repetitions’ own \
             standard deviations, which leaves out the spread between repetitions and is therefore smaller."
        }
        table .stack {
            thead { tr { th scope="col" { "Controller" } @for mode in MODES { th scope="col" { (mode_title(mode)) } } } }
            tbody { @for policy in &policies { @for source in ["the paper"].into_iter().chain(TRAININGS) {
                tr {
                    th scope="row" { (policy_label(policy)) div .note { (source_label(source)) } }
                    @for mode in MODES { td data-label=(mode_title(mode)) dir="ltr" { (cell(&rows, policy, mode, source)) } }
                }
            } } }
        }
        (strips)
    })
}

fn source_label(source: &str) -> String {
    if TRAININGS.contains(&source) {
        format!("ours, {}", training_label(source))
    } else {
        source.to_owned()
    }
}

/// Mean and standard deviation of a cell; a dash where it was not run.
fn cell(rows: &[ReachSummaryRow], policy: &str, mode: &str, source: &str) -> Markup {
    let is_cell = |row: &&ReachSummaryRow| row.cell.policy == policy && row.cell.mode == mode;
    let is_source = |row: &&ReachSummaryRow| row.training == source || source == "the paper";
    let numbers = rows.iter().filter(is_cell).find(is_source).map(|row| {
        if source == "the paper" {
            [row.paper_mean_m, row.paper_sd_m]
        } else {
            [row.mean_m, row.sd_m]
        }
    });
    let millimetres =
        |value_m: f64| html! { data value=(value_m) { (format!("{:.1}", 1e3 * value_m)) } };
    match numbers.filter(|numbers| numbers.iter().all(|number| number.is_finite())) {
        Some([mean_m, sd_m]) => html! { (millimetres(mean_m)) " (" (millimetres(sd_m)) ")" },
        None => html! { "–" },
    }
}

fn strips(results: &Path, data: &mut PageData) -> Result<Markup, DataError> {
    let file = "table1/trials.csv";
    let Some(columns) = published_columns(results, file)? else { return Ok(Markup::default()) };
    let wanted = ["training", "policy", "mode", "error_m"];
    let table = data.add(EmbeddedTable::new(file, &columns, &wanted, |_| true));
    let chart = Chart {
        kind: ChartKind::Strips,
        table,
        title: "Errors of all trials".into(),
        x: AxisColumn::millimetres("error_m", "distance from the target (mm)"),
        category: vec!["policy".into()],
        series: Some("policy"),
        facets: vec![("training", "paper".into()), ("mode", "closed".into())],
        ..Chart::default()
    };
    Ok(data.chart(
        chart,
        "One dot per trial (10 repetitions of 50 targets). Box: quartiles and median.",
    ))
}
