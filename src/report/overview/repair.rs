//! Changes of a robot: how many were noticed, identified and repaired, and the errors.

use maud::{Markup, html};
use std::path::Path;

use super::charts::{AxisColumn, Chart, PageData};
use super::sections::chart_of;
use crate::data::DataError;
use crate::report::html::{cells, table};
use crate::report::order::distinct;
use crate::report::published_rows;
use crate::rows::repairs::{MonitorRow, RepairRow, RepairSummaryRow};

/// The section; nothing without its tables.
///
/// # Errors
/// [`DataError`] for a table that cannot be read.
pub(super) fn section(results: &Path, data: &mut PageData) -> Result<Markup, DataError> {
    let folder = results.join("repair");
    let repairs: Vec<RepairRow> = published_rows(&folder)?;
    let summary: Vec<RepairSummaryRow> = published_rows(&folder)?;
    let monitors: Vec<MonitorRow> = published_rows(&folder)?;
    let chart = Chart {
        title: "Error before a change, after it, and repaired".into(),
        x: AxisColumn::millimetres("mean_m", "mean error (mm)"),
        interval: Some(["low_95_m", "high_95_m"]),
        category: vec!["change".into()],
        series: Some("variant"),
        facets: vec![("mode", "open".into()), ("policy", "a".into())],
        ..Chart::default()
    };
    let caption = "Mean over ten repetitions with its 95 % interval. Before: the robot as built. Changed: \
                   the changed robot with the unchanged controller. Repaired: networks trained further with the \
                   repaired model. Moved points: unchanged networks; the real points of the Gaussian process are \
                   moved by the predicted effect of the identified change. New points: a Gaussian process of as \
                   many new real points. New real: a network of as many new real samples.";
    let chart = chart_of(results, data, "repair/repair_summary.csv", |_| true, chart, caption)?;
    Ok(html! { (counts(&repairs, &summary, &monitors)) (chart) })
}

/// How many changes were noticed, identified and repaired.
fn counts(repairs: &[RepairRow], summary: &[RepairSummaryRow], monitors: &[MonitorRow]) -> Markup {
    if repairs.is_empty() {
        return Markup::default();
    }
    let lines: Vec<ChangeCounts> = distinct(repairs.iter().map(|row| row.change.as_str()))
        .into_iter()
        .map(|change| ChangeCounts::of(change, repairs, summary))
        .collect();
    let total = |value: fn(&ChangeCounts) -> usize| lines.iter().map(value).sum::<usize>();
    let hours: f64 = monitors.iter().map(|row| row.watched_s).sum::<f64>() / 3600.0;
    let false_alarms: u64 = monitors.iter().map(|row| row.false_alarms).sum();
    let rows: Vec<_> = lines
        .iter()
        .map(|line| {
            cells([
                line.name.clone(),
                format!("{} of {}", line.alarms, line.repetitions),
                format!("{} of {}", line.identified, line.repetitions),
                format!("{} of {}", line.otherwise, line.repetitions),
                format!("{} of {}", line.worse, line.compared),
            ])
        })
        .collect();
    let header = [
        "change",
        "alarm raised",
        "named alone and right",
        "other effects named, or several possible",
        "mean error larger after the repair",
    ];
    html! {
        p {
            "A monitor watches the robot at work. After an alarm the program records the changed robot, searches \
             for the change and repairs the controller. Over " (lines.len()) " changes and all repetitions it raised an alarm in "
            (total(|line| line.alarms)) " of " (total(|line| line.repetitions)) " cases and named the change, alone and without an \
             alternative, in " (total(|line| line.identified)) ", other or several effects in "
            (total(|line| line.otherwise)) " and none in the rest. In " (total(|line| line.worse)) " of "
            (total(|line| line.compared)) " comparisons (controller, loop and kind of repair) the mean error was larger after \
             the repair than before it. Without a change it raised " (false_alarms) " alarms in " (format!("{hours:.0}")) " hours. \
             Where no alarm was raised, recording and repair were done all the same."
        }
        (table(&header, &rows))
    }
}

/// The counts of one change.
struct ChangeCounts {
    name: String,
    repetitions: usize,
    /// Repetitions with an alarm.
    alarms: usize,
    /// Repetitions in which the change was named, alone and without an alternative.
    identified: usize,
    /// Repetitions in which something else was named, or something beside it.
    otherwise: usize,
    /// Repaired controllers whose mean error is larger than that of the unchanged ones.
    worse: usize,
    compared: usize,
}

impl ChangeCounts {
    fn of(change: &str, repairs: &[RepairRow], summary: &[RepairSummaryRow]) -> ChangeCounts {
        let rows = || repairs.iter().filter(|row| row.change == change);
        let identified =
            |row: &&RepairRow| row.verdict == "named" && effects(&row.named) == effects(&row.truth);
        let named = |row: &&RepairRow| !row.named.is_empty();
        let of_change = || summary.iter().filter(|row| row.change == change);
        let unrepaired_m = |row: &RepairSummaryRow| {
            let same = |other: &&RepairSummaryRow| {
                other.variant == "changed"
                    && other.training == row.training
                    && other.cell.mode == row.cell.mode
                    && other.cell.policy == row.cell.policy
            };
            of_change().find(same).map(|other| other.mean_m)
        };
        let pairs: Vec<(f64, f64)> = of_change()
            .filter(|row| !["before", "changed"].contains(&row.variant.as_str()))
            .filter_map(|row| Some((row.mean_m, unrepaired_m(row)?)))
            .collect();
        ChangeCounts {
            name: change.to_owned(),
            repetitions: rows().count(),
            alarms: rows().filter(|row| row.alarm_s.is_finite()).count(),
            identified: rows().filter(identified).count(),
            otherwise: rows().filter(|row| named(row) && !identified(row)).count(),
            worse: pairs.iter().filter(|(repaired_m, changed_m)| repaired_m > changed_m).count(),
            compared: pairs.len(),
        }
    }
}

/// The names in lines such as `tip_load: {mass_kg: 0.02}; damping: {…}`.
fn effects(lines: &str) -> Vec<&str> {
    lines.split("; ").filter_map(|effect| effect.split(':').next()).collect()
}
