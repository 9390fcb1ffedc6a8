//! When the tip begins to follow its commands, from commands and tracked frames alone: what tells
//! an offset of the two clocks without a model of the robot.

use nalgebra::{DMatrix, DVector};

use super::Log;
use crate::base::Point3;

/// Commands before the present one that may still move the tip.
const PAST_COMMANDS: usize = 4;
/// Offsets are tried up to this many steps on both sides, and at most so many seconds.
const MAX_OFFSET_STEPS: f64 = 2.0;
const MAX_OFFSET_S: f64 = 0.5;
/// Smallest distance of two offsets, seconds.
const OFFSET_STEP_S: f64 = 0.01;
/// Share of the tip's squares that the present command must explain beyond the earlier ones, and
/// how many times what chance explains.
const MIN_EXPLAINED_SHARE: f64 = 0.03;
const MIN_CHANCE_RATIO: f64 = 4.0;
/// Fewest rows.
const MIN_ROWS: usize = 40;
/// Directions of the commands below this share of the largest are none.
const RANK_TOLERANCE: f64 = 1e-9;

/// Time from a command of `log` to the first motion of the tip because of it, seconds, negative
/// when the tip moves first. `tip_at`: tip at a time of the export, metres. None when it cannot be
/// told: few rows, commands that can be foreseen from those before, a tip that does not follow.
pub(crate) fn onset_s(log: &Log, tip_at: &dyn Fn(f64) -> Option<Point3>) -> Option<f64> {
    let trials = log.commands.trials();
    let rows: Vec<usize> =
        trials.iter().flat_map(|(_, range)| range.clone().skip(PAST_COMMANDS)).collect();
    let steps_s: Vec<f64> = rows.iter().map(|&row| log.at_s[row] - log.at_s[row - 1]).collect();
    let step_s = crate::math::summary::quantile(&steps_s, 0.5);
    let max_offset_s = (MAX_OFFSET_STEPS * step_s).min(MAX_OFFSET_S);
    if max_offset_s.is_nan() || max_offset_s <= OFFSET_STEP_S {
        return None;
    }
    let count = (max_offset_s / OFFSET_STEP_S) as i32;
    let offsets_s: Vec<f64> = (-count..=count).map(|k| f64::from(k) * OFFSET_STEP_S).collect();
    let tips = |&row: &usize| -> Option<(usize, Vec<Point3>)> {
        let tips_m = offsets_s
            .iter()
            .map(|offset_s| tip_at(log.at_s[row] + offset_s))
            .collect::<Option<_>>()?;
        Some((row, tips_m))
    };
    let tips: Vec<(usize, Vec<Point3>)> = rows.iter().filter_map(tips).collect();
    if tips.len() < MIN_ROWS {
        return None;
    }
    // What the present command explains beyond the past ones, by projection on a basis of each.
    let basis = |from: usize| basis(&design(log, &tips, from));
    let (past, all) = (basis(1)?, basis(0)?);
    let added = all.ncols().checked_sub(past.ncols()).filter(|&added| added > 0)?;
    let chance = added as f64 / (tips.len() - all.ncols().min(tips.len() - 1)) as f64;
    let min_gain = MIN_EXPLAINED_SHARE.max(MIN_CHANCE_RATIO * chance);
    let gain = |offset: usize| {
        let residual = |basis: &DMatrix<f64>| -> f64 {
            let axis = |axis: usize| {
                let tip = DVector::from_iterator(
                    tips.len(),
                    tips.iter().map(|(_, tips_m)| tips_m[offset][axis]),
                );
                (tip.norm_squared() - basis.tr_mul(&tip).norm_squared()).max(0.0)
            };
            (0..3).map(axis).sum()
        };
        1.0 - residual(&all) / residual(&past).max(f64::MIN_POSITIVE)
    };
    let gains: Vec<f64> = (0..offsets_s.len()).map(gain).collect();
    let first = gains.windows(2).position(|pair| pair[0] > min_gain && pair[1] > min_gain)?;
    (first > 0).then(|| offsets_s[first])
}

/// A constant, and the commands from `from` steps ago to [`PAST_COMMANDS`] steps ago.
fn design(log: &Log, tips: &[(usize, Vec<Point3>)], from: usize) -> DMatrix<f64> {
    let width = log.commands.tendons();
    DMatrix::from_fn(tips.len(), 1 + width * (PAST_COMMANDS + 1 - from), |row, column| {
        let Some(place) = column.checked_sub(1) else { return 1.0 };
        log.commands.commands.row(tips[row].0 - from - place / width)[place % width]
    })
}

/// An orthonormal basis of the columns.
fn basis(design: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    // Columns of one size, so that metres beside a constant are not taken for rounding.
    let scaled = DMatrix::from_columns(
        &design
            .column_iter()
            .map(|column| column / column.norm().max(f64::MIN_POSITIVE))
            .collect::<Vec<_>>(),
    );
    let svd = scaled.svd(true, false);
    let largest = svd.singular_values.max();
    let significant: Vec<usize> = (0..svd.singular_values.len())
        .filter(|&k| svd.singular_values[k] > RANK_TOLERANCE * largest)
        .collect();
    svd.u.map(|u| u.select_columns(&significant))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Actuation, Recording};
    use rand_distr::{Distribution, Normal};

    /// Random steps of two tendons at 5 Hz, and a tip that follows each within 0.1 s, measured
    /// `ahead_s` early.
    fn onset(ahead_s: f64, foreseen: bool) -> Option<f64> {
        let (mut random, step, noise) = (
            crate::base::Seed(4).rng(),
            Normal::new(0.0, 2e-3).unwrap(),
            Normal::new(0.0, 3e-4).unwrap(),
        );
        let mut commands = Recording::new(Actuation::Lengths, 2);
        for row in 0..200 {
            commands.trial.push(0);
            commands.time_s.push(0.2 * f64::from(row));
            let angle = 0.1 * f64::from(row);
            let drawn = if foreseen {
                [angle.sin(), angle.cos()]
            } else {
                [step.sample(&mut random), step.sample(&mut random)]
            };
            commands.commands.push(&drawn);
        }
        let at_s = commands.time_s.iter().map(|time_s| time_s + 5.0).collect();
        let log = Log { file: "log.csv".into(), commands, at_s };
        let noise = std::cell::RefCell::new((random, noise));
        let tip_at = |time_s: f64| {
            let time_s = time_s - 5.0 + ahead_s;
            let place = ((time_s / 0.2).floor().max(0.0) as usize).min(199);
            let share = ((time_s - 0.2 * place as f64) / 0.1).clamp(0.0, 1.0);
            let [before, now] =
                [place.saturating_sub(1), place].map(|row| log.commands.commands.row(row));
            let noise = || {
                let (random, normal) = &mut *noise.borrow_mut();
                normal.sample(random)
            };
            let moved =
                |axis: usize| 4.0 * (before[axis] + share * (now[axis] - before[axis])) + noise();
            Some([moved(0), moved(1), 0.2])
        };
        onset_s(&log, &tip_at)
    }

    #[test]
    fn the_first_motion_after_or_before_a_command_is_seen() {
        for ahead_s in [-0.15, 0.0, 0.12] {
            let seen_s = onset(ahead_s, false).unwrap();
            assert!((seen_s + ahead_s - 0.02).abs() < 0.025, "{ahead_s}: {seen_s}");
        }
    }

    #[test]
    fn commands_that_can_be_foreseen_tell_nothing() {
        assert_eq!(onset(0.0, true), None);
    }
}
