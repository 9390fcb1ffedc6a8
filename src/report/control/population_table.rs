//! The tables behind [`super::population`]: errors over robots, what effects add to them, and on
//! how many a claim holds.

use std::collections::{BTreeMap, BTreeSet};

use super::controllers_table::mm;
use crate::math::distribution::{holm, student_95, student_beyond};
use crate::math::summary::{mean, quantile, rank_correlation, standard_deviation};
use crate::report::cells::{CellErrors, label_cells, mode_first, summarise_cells};
use crate::report::order::{rank, trainings};
use crate::report::page::markup::MarkdownTable;
use crate::report::paper::summarise::trial_error;
use crate::rows::experiment::TrialRow;
use crate::rows::population::{AttributionRow, PopulationRow, RobotClaimRow, RobotRow};

/// The errors of each policy, mode and data size; every repetition has a robot of its own.
fn by_policy(trials: &[TrialRow]) -> Vec<CellErrors<'_, TrialRow>> {
    let order = trainings(trials.iter().map(|row| row.training.as_str()));
    summarise_cells(trials, |row| (rank(&order, &row.training), mode_first(&row.cell)), trial_error)
}

/// The errors of each policy over robots.
pub(crate) fn population_rows(trials: &[TrialRow]) -> Vec<PopulationRow> {
    let row = |cell: CellErrors<TrialRow>| {
        let robots_m = cell.seed_means_m();
        let errors_m: Vec<f64> = robots_m.values().copied().collect();
        let largest = robots_m.iter().max_by(|one, other| one.1.total_cmp(other.1));
        PopulationRow {
            training: cell.rows[0].training.clone(),
            cell: cell.rows[0].cell.clone(),
            robots: errors_m.len() as u64,
            p05_m: quantile(&errors_m, 0.05),
            p25_m: quantile(&errors_m, 0.25),
            median_m: quantile(&errors_m, 0.5),
            p75_m: quantile(&errors_m, 0.75),
            p95_m: quantile(&errors_m, 0.95),
            largest_m: largest.map_or(f64::NAN, |(_, error_m)| *error_m),
            largest_seed: largest.map_or(0, |(seed, _)| *seed),
            failed: cell.failed(),
        }
    };
    by_policy(trials).into_iter().map(row).collect()
}

/// What each effect adds to the error of each policy, for effects that at least two robots have and
/// two have not.
pub(crate) fn attribution_rows(trials: &[TrialRow], robots: &[RobotRow]) -> Vec<AttributionRow> {
    // Strength by effect and robot.
    let mut strengths: BTreeMap<&str, BTreeMap<u64, f64>> = BTreeMap::new();
    for row in robots {
        strengths.entry(&row.effect).or_default().insert(row.seed, row.strength);
    }
    let mut rows = Vec::new();
    for cell in by_policy(trials) {
        let compared: Vec<(AttributionRow, f64)> = strengths
            .iter()
            .filter_map(|(effect, strengths)| attributed(&cell, effect, strengths))
            .collect();
        let p_values: Vec<f64> = compared.iter().map(|(_, p)| *p).collect();
        let corrected = holm(&p_values);
        rows.extend(
            compared
                .into_iter()
                .zip(corrected)
                .map(|((row, _), p_holm)| AttributionRow { p_holm, ..row }),
        );
    }
    rows
}

/// Robots with the effect against robots without it (Welch, Biometrika 34, 1947), and the
/// uncorrected p-value.
fn attributed(
    cell: &CellErrors<TrialRow>,
    effect: &str,
    strengths: &BTreeMap<u64, f64>,
) -> Option<(AttributionRow, f64)> {
    let robots_m = cell.seed_means_m();
    let (with, without): (Vec<_>, Vec<_>) =
        robots_m.iter().partition(|(seed, _)| strengths.contains_key(seed));
    let errors =
        |robots: &[(&u64, &f64)]| robots.iter().map(|(_, error_m)| **error_m).collect::<Vec<f64>>();
    let (with_m, without_m) = (errors(&with), errors(&without));
    if with_m.len() < 2 || without_m.len() < 2 {
        return None;
    }
    let squared_error_m2 =
        |errors_m: &[f64]| standard_deviation(errors_m).powi(2) / errors_m.len() as f64;
    let (a, b) = (squared_error_m2(&with_m), squared_error_m2(&without_m));
    // Degrees of freedom by Welch and Satterthwaite: the variances may differ.
    let freedom = (a + b).powi(2)
        / (a * a / (with_m.len() - 1) as f64 + b * b / (without_m.len() - 1) as f64);
    let difference_m = mean(&with_m) - mean(&without_m);
    let half_m = student_95(freedom) * (a + b).sqrt();
    let sizes: Vec<f64> =
        with.iter().filter_map(|(seed, _)| strengths.get(seed)).copied().collect();
    let row = AttributionRow {
        training: cell.rows[0].training.clone(),
        cell: cell.rows[0].cell.clone(),
        effect: effect.to_owned(),
        robots_with: with_m.len() as u64,
        robots_without: without_m.len() as u64,
        difference_m,
        low_95_m: difference_m - half_m,
        high_95_m: difference_m + half_m,
        rank_correlation: rank_correlation(&sizes, &with_m),
        p_holm: f64::NAN,
    };
    Some((row, student_beyond(difference_m / (a + b).sqrt(), freedom)))
}

/// The three tables in Markdown, errors in millimetres.
pub(crate) fn markdown(
    rows: &[PopulationRow],
    claims: &[RobotClaimRow],
    effects: &[AttributionRow],
) -> String {
    let decided: Vec<&AttributionRow> = effects.iter().filter(|row| row.p_holm < 0.05).collect();
    let compared_effects: BTreeSet<&str> = effects.iter().map(|row| row.effect.as_str()).collect();
    let mut text = format!(
        "Errors over robots in mm; that of a robot is its mean over targets.\n\n{}",
        error_table(rows).markdown()
    );
    if !claims.is_empty() {
        text += &format!(
            "\nRobots on which a claim of the paper holds.\n\n{}",
            claim_table(claims).markdown()
        );
    }
    text += &format!(
        "\nEffects that change an error (p below 0.05 after Holm's correction over {} effects), \
         mm.\n\n{}",
        compared_effects.len(),
        if decided.is_empty() { "None.\n".to_owned() } else { effect_table(&decided).markdown() }
    );
    text
}

fn error_table(rows: &[PopulationRow]) -> MarkdownTable {
    let line = |row: &PopulationRow| {
        let numbers = [row.median_m, row.p05_m, row.p95_m, row.largest_m].map(mm);
        let [robots, failed] = [row.robots, row.failed].map(|count| [count.to_string()]);
        [&label_cells(&row.training, &row.cell)[..], &robots, &numbers, &failed].concat()
    };
    let header =
        "policy | training | mode | robots | median | 5 % | 95 % | largest | failed trials";
    MarkdownTable::new(header, rows.iter().map(line))
}

fn claim_table(claims: &[RobotClaimRow]) -> MarkdownTable {
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    let line = |row: &RobotClaimRow| {
        let interval = format!("{} to {}", percent(row.low_95), percent(row.high_95));
        vec![
            row.statement.clone(),
            row.training.clone(),
            row.robots.to_string(),
            percent(row.share),
            interval,
        ]
    };
    MarkdownTable::new(
        "claim | training | robots | holds on | 95 % interval",
        claims.iter().map(line),
    )
}

fn effect_table(decided: &[&AttributionRow]) -> MarkdownTable {
    let line = |row: &&AttributionRow| {
        let interval = format!("{} to {}", mm(row.low_95_m), mm(row.high_95_m));
        let correlation = format!("{:.2}", row.rank_correlation);
        let cells = [
            row.effect.clone(),
            row.robots_with.to_string(),
            mm(row.difference_m),
            interval,
            correlation,
        ];
        [&label_cells(&row.training, &row.cell)[..], &cells].concat()
    };
    let header = "policy | training | mode | effect | robots with it | adds | 95 % interval | rank \
                  correlation";
    MarkdownTable::new(header, decided.iter().map(line))
}
