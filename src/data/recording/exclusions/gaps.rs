//! Gaps: rows, and with them commands, that are missing in a recording of regular steps. The robot
//! has moved under commands that nobody knows.

use super::Exclusion;
use crate::data::Recording;
use crate::math::summary::quantile;

/// A step longer than this many median steps is a gap.
const MIN_GAP_STEPS: f64 = 2.5;
/// Steps within this share of the median are regular, and this share of all steps must be. A
/// recording of other steps has pauses of its own.
const REGULAR_TOLERANCE: f64 = 0.05;
const MIN_REGULAR_SHARE: f64 = 0.95;
/// Time after which unknown commands have no influence, seconds.
const MEMORY_S: f64 = 1.0;

/// Rows after gaps.
pub(super) fn find(measured: &Recording) -> Vec<Exclusion> {
    let trials = measured.trials();
    let step_s = |row: usize| measured.time_s[row] - measured.time_s[row - 1];
    let steps_s: Vec<f64> =
        trials.iter().flat_map(|(_, rows)| (rows.start + 1..rows.end).map(step_s)).collect();
    let median_s = quantile(&steps_s, 0.5);
    let regular = steps_s
        .iter()
        .filter(|step_s| (**step_s - median_s).abs() <= REGULAR_TOLERANCE * median_s)
        .count();
    if (regular as f64) < MIN_REGULAR_SHARE * steps_s.len() as f64 {
        return Vec::new();
    }
    let mut exclusions = Vec::new();
    for (_, rows) in trials {
        for gap in (rows.start + 1..rows.end).filter(|&row| step_s(row) > MIN_GAP_STEPS * median_s)
        {
            let [from_s, to_s] = [gap - 1, gap].map(|row| measured.time_s[row]);
            let why =
                format!("rows between {from_s} s and {to_s} s and their commands are missing");
            let affected =
                (gap..rows.end).take_while(|&row| measured.time_s[row] <= to_s + MEMORY_S);
            exclusions.extend(affected.map(|row| Exclusion { row, why: why.clone() }));
        }
    }
    exclusions.dedup_by_key(|excluded| excluded.row);
    exclusions
}

#[cfg(test)]
mod tests {
    use super::super::circles;

    #[test]
    fn rows_after_missing_rows_are_excluded() {
        let (mut measured, _) = circles();
        assert!(super::find(&measured).is_empty());
        measured.time_s[100..120].iter_mut().for_each(|time_s| *time_s += 1.4);
        let rows: Vec<usize> = super::find(&measured).iter().map(|excluded| excluded.row).collect();
        assert_eq!(rows, (100..106).collect::<Vec<_>>());
        // Rows of unequal steps are pauses.
        (0..3).for_each(|trial| {
            measured.time_s[60 * trial + 30..60 * (trial + 1)].iter_mut().for_each(|t| *t *= 2.0)
        });
        assert!(super::find(&measured).is_empty());
    }
}
