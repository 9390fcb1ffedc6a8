//! The table behind [`super::controllers`]: responses summarised by policy and mode, and laps
//! beside them.

use crate::math::summary::{mean, quantile};
use crate::report::cells::{CellErrors, SeedError, label_cells, mode_first, summarise_cells};
use crate::report::order::{ascending, rank, trainings};
use crate::report::page::markup::MarkdownTable;
use crate::rows::responses::{ControllerRow, PaceRow, ResponseRow};

/// Responses, summarised by training, mode and policy.
pub(crate) fn controller_rows(responses: &[ResponseRow]) -> Vec<ControllerRow> {
    let order = trainings(responses.iter().map(|row| row.training.as_str()));
    let error = |row: &ResponseRow| SeedError {
        seed: row.seed,
        error_m: row.status.is_ok().then_some(row.error_end_m),
    };
    let cells = summarise_cells(
        responses,
        |row| (rank(&order, &row.training), mode_first(&row.cell)),
        error,
    );
    cells.iter().map(summarised).collect()
}

fn summarised(cell: &CellErrors<ResponseRow>) -> ControllerRow {
    let column = |value: fn(&ResponseRow) -> f64| -> Vec<f64> {
        cell.good.iter().map(|row| value(row)).collect()
    };
    let [low_95_m, high_95_m] = cell.interval_95_m();
    let within_3mm = cell.good.iter().filter(|row| row.within_3mm_s.is_finite()).count();
    ControllerRow {
        training: cell.rows[0].training.clone(),
        cell: cell.rows[0].cell.clone(),
        error_end_m: cell.mean_m(),
        low_95_m,
        high_95_m,
        error_end_p95_m: quantile(&column(|row| row.error_end_m), 0.95),
        tracked_end_m: mean(&column(|row| row.tracked_end_m)),
        within_5mm_s: median_time(&column(|row| row.within_5mm_s)),
        within_3mm_s: median_time(&column(|row| row.within_3mm_s)),
        within_2mm_s: median_time(&column(|row| row.within_2mm_s)),
        within_3mm_share: within_3mm as f64 / cell.good.len() as f64,
        within_3mm_per_limit: median_time(&column(|row| row.within_3mm_s / row.limit_s)),
        error_1s_m: mean(&column(|row| row.error_1s_m)),
        error_2s_m: mean(&column(|row| row.error_2s_m)),
        error_5s_m: mean(&column(|row| row.error_5s_m)),
        overshoot_m: mean(&column(|row| row.overshoot_m)),
        tendon_travel_m: mean(&column(|row| row.tendon_travel_m)),
        seeds: cell.seeds(),
        trials: cell.good.len() as u64,
        failed: cell.failed(),
    }
}

/// The median where what never happened takes longest; not a number where that is half of all.
fn median_time(times_s: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = times_s
        .iter()
        .map(|&time_s| if time_s.is_nan() { f64::INFINITY } else { time_s })
        .collect();
    sorted.sort_by(f64::total_cmp);
    let upper = sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN);
    let lower = sorted.get(sorted.len().saturating_sub(1) / 2).copied().unwrap_or(f64::NAN);
    let median = 0.5 * (lower + upper);
    if median.is_finite() { median } else { f64::NAN }
}

/// Both tables in Markdown, lengths in millimetres.
pub(crate) fn markdown(rows: &[ControllerRow], paces: &[PaceRow]) -> String {
    let head = "Errors of the true tip in mm: mean at the end (95 % interval over repetitions), \
                the same as tracked, 95th percentile, and after 1, 2 and 5 s. Times in s: median \
                until the error stays within 5, 3 and 2 mm. “Limit”: median of the time to within \
                3 mm over the minimum time at the speed limit of the drives. “–”: not reached in \
                half of the trials.\n\n";
    let mut text = head.to_owned() + &responses_table(rows).markdown();
    if !paces.is_empty() {
        text.push_str(
            "\nPath tracking: root mean square of the distance from the moving target, \
                       mm, by speed.\n\n",
        );
        text.push_str(&paces_table(paces).markdown());
    }
    text
}

fn responses_table(rows: &[ControllerRow]) -> MarkdownTable {
    let line = |row: &ControllerRow| {
        let interval =
            format!("{} ({}–{})", mm(row.error_end_m), mm(row.low_95_m), mm(row.high_95_m));
        let errors_m = [
            row.tracked_end_m,
            row.error_end_p95_m,
            row.error_1s_m,
            row.error_2s_m,
            row.error_5s_m,
        ];
        let times_s =
            [row.within_5mm_s, row.within_3mm_s, row.within_2mm_s].map(|time_s| number(time_s, 1));
        let travel = [
            number(row.within_3mm_per_limit, 2),
            mm(row.overshoot_m),
            number(row.tendon_travel_m, 3),
        ];
        let label = label_cells(&row.training, &row.cell);
        [&label[..], &[interval], &errors_m.map(mm), &times_s, &travel, &[row.failed.to_string()]]
            .concat()
    };
    let header = "policy | training | mode | end | tracked | 95 % | 1 s | 2 s | 5 s | to 5 mm | to \
                  3 mm | to 2 mm | limit | overshoot | tendons (m) | failed";
    MarkdownTable::new(header, rows.iter().map(line))
}

fn paces_table(paces: &[PaceRow]) -> MarkdownTable {
    let order = trainings(paces.iter().map(|row| row.training.as_str()));
    let speeds = ascending(paces.iter().map(|row| row.speed));
    let error = |row: &PaceRow| SeedError {
        seed: row.seed,
        error_m: row.status.is_ok().then_some(row.rms_m),
    };
    let cells =
        summarise_cells(paces, |row| (rank(&order, &row.training), mode_first(&row.cell)), error);
    let line = |cell: &CellErrors<PaceRow>| {
        let at = |speed: &f64| {
            let same_speed = cell.good.iter().filter(|row| row.speed == *speed);
            mm(mean(&same_speed.map(|row| row.rms_m).collect::<Vec<_>>()))
        };
        label_cells(&cell.rows[0].training, &cell.rows[0].cell)
            .into_iter()
            .chain(speeds.iter().map(at))
            .collect()
    };
    let mut table = MarkdownTable::new("policy | training | mode", cells.iter().map(line));
    table.header.extend(speeds.iter().map(|speed| format!("{speed}×")));
    table
}

/// A length in millimetres; a dash for none.
pub(crate) fn mm(length_m: f64) -> String {
    number(1e3 * length_m, 2)
}

fn number(value: f64, digits: usize) -> String {
    if value.is_finite() { format!("{value:.digits$}") } else { "–".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trials_that_never_arrive_take_longest() {
        assert_eq!(median_time(&[1.0, f64::NAN, 2.0]), 2.0);
        assert_eq!(median_time(&[1.0, 3.0, 2.0, f64::NAN]), 2.5);
        assert!(median_time(&[1.0, f64::NAN]).is_nan());
    }
}
