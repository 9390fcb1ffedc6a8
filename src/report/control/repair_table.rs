//! The tables behind [`super::repair`]: what was noticed and named, and the errors by change, mode,
//! policy and variant.

use std::collections::BTreeMap;

use super::controllers_table::mm;
use crate::math::summary::{mean, quantile, standard_deviation};
use crate::report::Published;
use crate::report::cells::{CellErrors, SeedError, mode_first, summarise_cells};
use crate::report::order::{Labels, distinct, last_training, rank, trainings};
use crate::report::page::markup::MarkdownTable;
use crate::report::style::{policy_markdown, policy_rank};
use crate::rows::repairs::{RepairRow, RepairSummaryRow, RepairTrialRow};

/// The variants in their order, and how a narrow axis calls them.
pub(crate) const VARIANTS: Labels = Labels(&[
    ("before", "before"),
    ("changed", "after"),
    ("repaired", "repair"),
    ("moved_points", "moved"),
    ("new_points", "points"),
    ("new_real", "data"),
]);

/// Trials, summarised by training, mode, change, policy and variant.
pub(crate) fn summary_rows(
    trials: &[RepairTrialRow],
    repairs: &[RepairRow],
) -> Vec<RepairSummaryRow> {
    let order = trainings(trials.iter().map(|row| row.training.as_str()));
    let changes = distinct(trials.iter().map(|row| row.change.as_str()));
    let key = |row: &RepairTrialRow| (rank(&order, &row.training), rank(&changes, &row.change));
    let error = |row: &RepairTrialRow| SeedError::of(row.seed, &row.status, row.error_m);
    let cells = summarise_cells(
        trials,
        |row| {
            let ((training, change), (mode, policy, sizes)) = (key(row), mode_first(&row.cell));
            (training, mode, change, policy, sizes, VARIANTS.rank(&row.variant))
        },
        error,
    );
    let before_m = |row: &RepairTrialRow| {
        let before = cells.iter().find(|cell| {
            let other = cell.rows[0];
            key(other) == key(row) && other.cell == row.cell && VARIANTS.rank(&other.variant) == 0
        });
        before.map_or(f64::NAN, CellErrors::mean_m)
    };
    cells.iter().map(|cell| summary(cell, before_m(cell.rows[0]), repairs)).collect()
}

fn summary(
    cell: &CellErrors<RepairTrialRow>,
    before_m: f64,
    repairs: &[RepairRow],
) -> RepairSummaryRow {
    let RepairTrialRow { training, change, variant, cell: label, .. } = cell.rows[0];
    let [low_95_m, high_95_m] = cell.interval_95_m();
    let diagnosed = repairs.iter().find(|row| row.change == *change && row.training == *training);
    let new_samples = match variant.as_str() {
        "repaired" | "moved_points" => diagnosed.map_or(0, |row| row.samples),
        "new_points" => label.gp_points,
        "new_real" => label.real_points,
        _ => 0,
    };
    RepairSummaryRow {
        training: training.clone(),
        change: change.clone(),
        variant: variant.clone(),
        cell: label.clone(),
        new_samples,
        mean_m: cell.mean_m(),
        low_95_m,
        high_95_m,
        sd_m: standard_deviation(&cell.good.iter().map(|row| row.error_m).collect::<Vec<_>>()),
        of_before: cell.mean_m() / before_m,
        seeds: cell.seeds(),
        trials: cell.good.len() as u64,
        failed: cell.failed(),
    }
}

/// What was noticed and named, then the errors, in Markdown.
pub(crate) fn markdown(rows: &[RepairSummaryRow], published: &Published) -> String {
    let mut text = noticed(published);
    text.push_str(&named_table(&published.repairs).markdown());
    text.push_str(
        "\nErrors of goal reaching in mm (95 % interval over repetitions). “After”: the changed \
         robot with the unchanged controller. “Repaired”: networks trained further with the \
         repaired model. “Moved points”: unchanged networks; the real points of the error model \
         are moved by the predicted effect of the named changes. Both use the samples of the table \
         above. “New points”: an error model of the same number of new real points. “New data”: a \
         network of the same number of new real samples.\n",
    );
    for training in trainings(rows.iter().map(|row| row.training.as_str())) {
        for mode in distinct(
            rows.iter().filter(|row| row.training == training).map(|row| row.cell.mode.as_str()),
        ) {
            text.push_str(&format!(
                "\n{} loop, training: {training}\n\n",
                if mode == "open" { "Open" } else { mode }
            ));
            let of_table =
                |row: &&RepairSummaryRow| row.training == training && row.cell.mode == mode;
            text.push_str(
                &errors_table(&rows.iter().filter(of_table).collect::<Vec<_>>()).markdown(),
            );
        }
    }
    text.replace("\nclosed loop, ", "\nClosed loop, ")
}

fn noticed(published: &Published) -> String {
    let ok: Vec<_> = published.monitors.iter().filter(|row| row.status.is_ok()).collect();
    let hours: f64 = ok.iter().map(|row| row.watched_s).sum::<f64>() / 3600.0;
    let alarms: u64 = ok.iter().map(|row| row.false_alarms).sum();
    format!(
        "The monitors raised {alarms} false alarms in {hours:.0} hours of work of unchanged \
         robots.\n\nAlarm: median time of work from a change to the alarm (repetitions with an \
         alarm). Named: number of repetitions by named effects. Nearest: mean distance of the \
         targets, drawn from the workspace of the unchanged robot, from the nearest equilibrium \
         position of the tip of the changed robot{}.\n\n",
        nearest_before(published)
    )
}

/// The same of the unchanged robot, where it is known.
fn nearest_before(published: &Published) -> String {
    let nearest_m: Vec<f64> = published.identifications.iter().map(|row| row.nearest_m).collect();
    let nearest_m = mean(&nearest_m);
    if nearest_m.is_finite() {
        format!(" ({} mm before the change)", mm(nearest_m))
    } else {
        String::new()
    }
}

/// One line a change: how soon it was noticed, and what it was said to be.
fn named_table(repairs: &[RepairRow]) -> MarkdownTable {
    let last = last_training(repairs.iter().map(|row| row.training.as_str()));
    let of_last: Vec<&RepairRow> = repairs.iter().filter(|row| row.training == last).collect();
    let line = |change: &str| {
        let of_change: Vec<&RepairRow> =
            of_last.iter().copied().filter(|row| row.change == change).collect();
        let alarms_s: Vec<f64> =
            of_change.iter().map(|row| row.alarm_s).filter(|time_s| time_s.is_finite()).collect();
        let alarm = match alarms_s.len() {
            0 => "–".to_owned(),
            count => format!("{:.1} s ({count} of {})", quantile(&alarms_s, 0.5), of_change.len()),
        };
        let samples = of_change.iter().map(|row| row.samples).max().unwrap_or(0);
        let mean_mm = |value: fn(&RepairRow) -> f64| {
            mm(mean(&of_change.iter().map(|row| value(row)).collect::<Vec<_>>()))
        };
        vec![
            change.to_owned(),
            of_change.first().map_or_else(String::new, |row| format!("`{}`", row.truth)),
            alarm,
            samples.to_string(),
            named_counts(&of_change),
            format!("{} → {}", mean_mm(|row| row.gap_before_m), mean_mm(|row| row.gap_after_m)),
            mean_mm(|row| row.nearest_m),
        ]
    };
    let header =
        "change | what changed | alarm | samples | named | held-out error (mm) | nearest (mm)";
    MarkdownTable::new(
        header,
        distinct(of_last.iter().map(|row| row.change.as_str())).into_iter().map(line),
    )
}

/// The names of the effects that were named, each with its count; the most frequent first.
fn named_counts(rows: &[&RepairRow]) -> String {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for row in rows {
        let names: Vec<&str> =
            row.named.split("; ").filter_map(|effect| effect.split(':').next()).collect();
        let names = if row.named.is_empty() { row.verdict.clone() } else { names.join(" + ") };
        let doubt = if row.verdict == "ambiguous" { " (ambiguous)" } else { "" };
        *counts.entry(names + doubt).or_default() += 1;
    }
    let mut sorted: Vec<(String, usize)> = counts.into_iter().collect();
    sorted.sort_by_key(|(names, count)| (std::cmp::Reverse(*count), names.clone()));
    sorted.iter().map(|(names, count)| format!("{count} {names}")).collect::<Vec<_>>().join(", ")
}

fn errors_table(rows: &[&RepairSummaryRow]) -> MarkdownTable {
    let mut cells: BTreeMap<(usize, usize, &str), Vec<&RepairSummaryRow>> = BTreeMap::new();
    let changes = distinct(rows.iter().map(|row| row.change.as_str()));
    for row in rows {
        let key =
            (rank(&changes, &row.change), policy_rank(&row.cell.policy), row.cell.policy.as_str());
        cells.entry(key).or_default().push(row);
    }
    let line = |rows: &Vec<&RepairSummaryRow>| {
        let cell = |(variant, _): &(&str, &str)| {
            let of_variant = rows.iter().find(|row| row.variant == *variant);
            of_variant.map_or_else(|| "–".to_owned(), |row| with_interval(row))
        };
        let mut line =
            vec![rows[0].change.clone(), policy_markdown(&rows[0].cell.policy).to_owned()];
        line.extend(VARIANTS.0.iter().map(cell));
        line
    };
    let header =
        "change | policy | before | after | repaired | moved points | new points | new data";
    MarkdownTable::new(header, cells.values().map(line))
}

fn with_interval(row: &RepairSummaryRow) -> String {
    if row.low_95_m.is_finite() {
        return format!("{} ({}–{})", mm(row.mean_m), mm(row.low_95_m), mm(row.high_95_m));
    }
    mm(row.mean_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::cell::{CellLabel, Outcome};

    fn trial(seed: u64, variant: &str, error_m: f64, status: &str) -> RepairTrialRow {
        RepairTrialRow {
            seed,
            training: "converged".into(),
            change: "load".into(),
            variant: variant.into(),
            cell: CellLabel {
                policy: "a".into(),
                mode: "closed".into(),
                gp_points: 100,
                real_points: 0,
            },
            target: 0,
            error_m,
            steps: 1,
            settled: true,
            status: Outcome::from(status.to_owned()),
        }
    }

    #[test]
    fn variants_are_compared_with_before_and_failures_counted() {
        let rows = [
            trial(0, "before", 0.002, "ok"),
            trial(1, "before", 0.004, "ok"),
            trial(0, "new_points", 0.006, "ok"),
            trial(1, "new_points", f64::NAN, "plant: broken"),
        ];
        let rows = summary_rows(&rows, &[]);
        let of: Vec<(&str, u64, u64)> =
            rows.iter().map(|row| (row.variant.as_str(), row.new_samples, row.failed)).collect();
        assert_eq!(of, [("before", 0, 0), ("new_points", 100, 1)]);
        assert!((rows[0].mean_m - 0.003).abs() < 1e-15 && (rows[1].of_before - 2.0).abs() < 1e-12);
    }
}
