//! Jumps of the tip by one, two or three rows that neither the robot nor a wrong model can make:
//! both ways, far above the local variation of the residual, and against the motion that the model
//! predicts.

use super::{Exclusion, difference_m, dot, length};
use crate::base::Point3;
use crate::math::summary::quantile;

/// Jumps above this many robust standard deviations of the residual's change count.
///
/// Chosen on recordings of an independent chain (`recordings/twin`): friction, delay, anisotropy
/// and payloads stay below 8, jumps of 9 mm at a noise of 0.5 mm are above 17.
const MIN_SIGNIFICANCE: f64 = 10.0;
/// … and above this share of the largest predicted step nearby, since effects act where the robot
/// moves.
const MIN_MOTION_SHARE: f64 = 0.5;
/// Longest jump, rows. Longer excursions may be physical.
const MAX_JUMP_ROWS: usize = 3;
/// Median length of a vector of three independent standard normal numbers.
const MEDIAN_LENGTH: f64 = 1.538;
/// Smallest standard deviation, metres: rounding of recorded numbers.
const MIN_SIGMA_M: f64 = 1e-5;
/// Fewest rows of a trial from which its ends are judged.
const MIN_TRIAL_ROWS: usize = 6;

/// Jumps of the place called `what` in `trials`, lists of rows in which it was seen.
pub(super) fn find(
    what: &str,
    positions_m: &[Point3],
    predicted_m: &[Point3],
    trials: &[Vec<usize>],
) -> Vec<Exclusion> {
    let residual_m: Vec<Point3> = positions_m
        .iter()
        .zip(predicted_m)
        .map(|(measured, predicted)| difference_m(measured, predicted))
        .collect();
    let scale = Scale::new(&residual_m, predicted_m, trials);
    let starts_agree = starts_agree(&residual_m, trials, &scale);
    let mut exclusions = Vec::new();
    for trial in trials {
        let mut kept = trial.clone();
        // One after the other, the largest first: a jump disturbs the comparison of its neighbours.
        while let Some(Jump { places, size_m, .. }) =
            largest_jump(&kept, &residual_m, predicted_m, &scale, starts_agree)
        {
            for &row in &kept[places.clone()] {
                exclusions.push(Exclusion {
                    row,
                    why: format!("{what} jumps by {:.1} mm and returns", 1e3 * size_m),
                });
            }
            kept.drain(places);
        }
    }
    exclusions.sort_by_key(|excluded| excluded.row);
    exclusions
}

/// A jump among the rows that are kept of a trial.
struct Jump {
    /// Places among these rows.
    places: std::ops::Range<usize>,
    size_m: f64,
    significance: f64,
}

/// The most significant jump among the rows `kept` of a trial.
fn largest_jump(
    kept: &[usize],
    residual_m: &[Point3],
    predicted_m: &[Point3],
    scale: &Scale,
    starts_agree: bool,
) -> Option<Jump> {
    let mut largest: Option<Jump> = None;
    for first in 0..kept.len() {
        for count in 1..=MAX_JUMP_ROWS.min(kept.len() - first) {
            let places = first..first + count;
            if first == 0 && !starts_agree {
                continue;
            }
            let size_m = jump_m(kept, &places, residual_m);
            let motion_m = largest_step_m(predicted_m, kept[first], kept[first + count - 1]);
            let rows = count as f64;
            let significance = size_m / (rows * scale.sigma_m(motion_m));
            let is_largest = largest.as_ref().is_none_or(|jump| significance > jump.significance);
            if significance > MIN_SIGNIFICANCE
                && size_m > rows * MIN_MOTION_SHARE * motion_m
                && is_largest
            {
                largest = Some(Jump { places, size_m, significance });
            }
        }
    }
    largest
}

/// How far the residual at `places` of `kept` stands out from the rows before and after them,
/// metres: the smaller of the ways there and back along their common direction. At an end of the
/// trial half the only way.
fn jump_m(kept: &[usize], places: &std::ops::Range<usize>, residual_m: &[Point3]) -> f64 {
    let at = |place: usize| &residual_m[kept[place]];
    let before = places.start.checked_sub(1).map(at);
    let after = (places.end < kept.len()).then(|| at(places.end));
    let sizes_m = places.clone().map(|place| match (before, after) {
        (Some(before), Some(after)) => {
            let (from_before, from_after) =
                (difference_m(at(place), before), difference_m(at(place), after));
            let direction: Point3 =
                std::array::from_fn(|axis| from_before[axis] + from_after[axis]);
            let norm = length(&direction).max(f64::MIN_POSITIVE);
            (dot(&from_before, &direction) / norm).min(dot(&from_after, &direction) / norm)
        }
        (Some(neighbour), None) | (None, Some(neighbour)) if kept.len() >= MIN_TRIAL_ROWS => {
            0.5 * length(&difference_m(at(place), neighbour))
        }
        _ => 0.0,
    });
    sizes_m.fold(f64::INFINITY, f64::min)
}

/// Largest predicted step from the row before `first` to two rows after `last`, metres. Effects may
/// delay motion.
fn largest_step_m(predicted_m: &[Point3], first: usize, last: usize) -> f64 {
    let rows = first.saturating_sub(1)..(last + 3).min(predicted_m.len());
    let nearby = &predicted_m[rows];
    nearby
        .windows(2)
        .map(|pair| length(&difference_m(&pair[1], &pair[0])))
        .fold(0.0, |a: f64, b| if b > a { b } else { a })
}

/// Standard deviation of the change of the residual from row to row, as a function of the predicted
/// motion.
struct Scale {
    at_rest_m: f64,
    /// Increase of the variance with the squared motion.
    per_motion: f64,
}

impl Scale {
    /// Medians over the slower and the faster half of the rows, which single jumps do not move.
    fn new(residual_m: &[Point3], predicted_m: &[Point3], trials: &[Vec<usize>]) -> Scale {
        let step = |pair: &[usize]| {
            let moved =
                |points: &[Point3]| length(&difference_m(&points[pair[1]], &points[pair[0]]));
            (moved(predicted_m), moved(residual_m))
        };
        let steps: Vec<(f64, f64)> =
            trials.iter().flat_map(|rows| rows.windows(2).map(step)).collect();
        let motions: Vec<f64> = steps.iter().map(|(motion_m, _)| *motion_m).collect();
        let middle = quantile(&motions, 0.5);
        let half = |fast: bool| {
            let steps_of_half: Vec<(f64, f64)> = steps
                .iter()
                .copied()
                .filter(|(motion_m, _)| (*motion_m > middle) == fast)
                .collect();
            let changes: Vec<f64> = steps_of_half.iter().map(|(_, change_m)| *change_m).collect();
            let squares: Vec<f64> =
                steps_of_half.iter().map(|(motion_m, _)| motion_m * motion_m).collect();
            (quantile(&changes, 0.5) / MEDIAN_LENGTH, quantile(&squares, 0.5))
        };
        let ((slow_m, slow_m2), (fast_m, fast_m2)) = (half(false), half(true));
        let variance_growth = (fast_m * fast_m - slow_m * slow_m).max(0.0)
            / (fast_m2 - slow_m2).max(MIN_SIGMA_M * MIN_SIGMA_M);
        Scale {
            at_rest_m: if slow_m.is_nan() { f64::INFINITY } else { slow_m.max(MIN_SIGMA_M) },
            per_motion: if variance_growth.is_nan() { 0.0 } else { variance_growth },
        }
    }

    fn sigma_m(&self, motion_m: f64) -> f64 {
        (self.at_rest_m.powi(2) + self.per_motion * motion_m * motion_m).sqrt()
    }
}

/// Whether the trials start alike, as trials that start settled at home do. Only then is a first
/// row that differs a jump.
fn starts_agree(residual_m: &[Point3], trials: &[Vec<usize>], scale: &Scale) -> bool {
    let starts: Vec<&Point3> =
        trials.iter().filter_map(|rows| rows.first()).map(|&row| &residual_m[row]).collect();
    let centre: Point3 = std::array::from_fn(|axis| {
        quantile(&starts.iter().map(|start| start[axis]).collect::<Vec<f64>>(), 0.5)
    });
    let close = starts
        .iter()
        .filter(|start| length(&difference_m(start, &centre)) < MIN_SIGNIFICANCE * scale.at_rest_m)
        .count();
    starts.len() > 2 && 2 * close > starts.len()
}

#[cfg(test)]
mod tests {
    use super::super::{Exclusions, circles};

    /// Jumps of one to three rows in any direction, at the ends of trials too.
    #[test]
    fn jumps_are_found_wherever_they_are() {
        for (rows, size_m) in [
            (vec![70], 0.015),
            (vec![60], 0.05),
            (vec![119], 0.05),
            (vec![70, 71], 0.04),
            (vec![30, 31, 32], 0.06),
        ] {
            for axis in 0..3 {
                let (mut measured, predicted_m) = circles();
                rows.iter().for_each(|&row| measured.tip_m.as_mut().unwrap()[row][axis] -= size_m);
                let exclusions = Exclusions::find(&measured, &predicted_m);
                assert_eq!(
                    exclusions.jumps.iter().map(|jump| jump.row).collect::<Vec<_>>(),
                    rows,
                    "axis {axis}"
                );
            }
        }
    }

    /// Neighbouring rows that jump apart, each to another place.
    #[test]
    fn neighbouring_jumps_are_both_found() {
        let (mut measured, predicted_m) = circles();
        let tips_m = measured.tip_m.as_mut().unwrap();
        tips_m[41][0] += 0.01;
        tips_m[42][1] -= 0.012;
        let exclusions = Exclusions::find(&measured, &predicted_m);
        assert_eq!(exclusions.jumps.iter().map(|jump| jump.row).collect::<Vec<_>>(), [41, 42]);
    }

    /// A step that stays, and a bump of a second, may be physical: a contact, a payload that falls.
    #[test]
    fn what_lasts_is_no_jump() {
        for rows in [70..120, 70..76] {
            let (mut measured, predicted_m) = circles();
            rows.for_each(|row| measured.tip_m.as_mut().unwrap()[row][0] += 0.015);
            assert!(Exclusions::find(&measured, &predicted_m).jumps.is_empty());
        }
    }

    /// Trials that start anywhere are not outliers at their starts.
    #[test]
    fn starts_that_differ_everywhere_stay() {
        let (mut measured, predicted_m) = circles();
        for (trial, size_m) in [0.02, -0.03, 0.05].into_iter().enumerate() {
            measured.tip_m.as_mut().unwrap()[60 * trial][0] += size_m;
        }
        assert!(Exclusions::find(&measured, &predicted_m).is_empty());
    }
}
