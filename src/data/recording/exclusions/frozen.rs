//! Poses that repeat to the last bit while the robot moves: a tracker that has stopped and still
//! sends.

use super::{Exclusion, difference_m, length};
use crate::base::Point3;
use crate::data::Recording;

/// Fewest equal poses in a row.
const MIN_REPEATS: usize = 3;
/// The model's tip must move by more than this, metres, and by more than this many of the smallest
/// recorded differences: a tracker that rounds to millimetres repeats a pose without being frozen.
const MIN_MOTION_M: f64 = 1e-3;
const MIN_MOTION_QUANTA: f64 = 5.0;

/// Rows that repeat the pose before them. The first pose of a run is genuine.
pub(super) fn find(
    measured: &Recording,
    tips_m: &[Point3],
    predicted_m: &[Point3],
    trials: &[Vec<usize>],
) -> Vec<Exclusion> {
    let min_motion_m = MIN_MOTION_M.max(MIN_MOTION_QUANTA * quantum_m(tips_m, trials));
    let mut exclusions = Vec::new();
    for rows in trials {
        for run in
            rows.chunk_by(|a, b| tips_m[*a] == tips_m[*b]).filter(|run| run.len() >= MIN_REPEATS)
        {
            let first = run[0];
            let distance_m =
                |row: &usize| length(&difference_m(&predicted_m[*row], &predicted_m[first]));
            let moved_m = run.iter().map(distance_m).fold(0.0, f64::max);
            if moved_m > min_motion_m {
                let since_s = measured.time_s[first];
                let why = format!(
                    "the pose is identical to that at {since_s} s while the model moves by {:.1} \
                     mm",
                    1e3 * moved_m
                );
                exclusions.extend(run[1..].iter().map(|&row| Exclusion { row, why: why.clone() }));
            }
        }
    }
    exclusions
}

/// The smallest difference of a coordinate from one row to the next that is not 0, metres.
fn quantum_m(tips_m: &[Point3], trials: &[Vec<usize>]) -> f64 {
    let pairs = trials.iter().flat_map(|rows| rows.windows(2));
    let steps =
        pairs.flat_map(|pair| difference_m(&tips_m[pair[1]], &tips_m[pair[0]])).map(f64::abs);
    let smallest_m = steps.filter(|step_m| *step_m > 0.0).fold(f64::INFINITY, f64::min);
    if smallest_m.is_finite() { smallest_m } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::super::{Exclusions, circles};

    #[test]
    fn repeats_are_excluded_and_the_first_pose_stays() {
        let (mut measured, predicted_m) = circles();
        let tips_m = measured.tip_m.as_mut().unwrap();
        (81..91).for_each(|row| tips_m[row] = tips_m[80]);
        let exclusions = Exclusions::find(&measured, &predicted_m);
        assert_eq!(
            exclusions.frozen.iter().map(|frozen| frozen.row).collect::<Vec<_>>(),
            (81..91).collect::<Vec<_>>()
        );
        assert!(exclusions.jumps.is_empty() && exclusions.gaps.is_empty());
    }

    /// A robot at rest measured without noise, and a tracker that rounds to 2 mm.
    #[test]
    fn a_robot_at_rest_and_a_coarse_tracker_are_not_frozen() {
        let (mut measured, mut predicted_m) = circles();
        let tips_m = measured.tip_m.as_mut().unwrap();
        (81..91).for_each(|row| (tips_m[row], predicted_m[row]) = (tips_m[80], predicted_m[80]));
        assert!(Exclusions::find(&measured, &predicted_m).frozen.is_empty());
        let (mut measured, _) = circles();
        let slow: Vec<[f64; 3]> = (0..180).map(|row| [1e-5 * f64::from(row), 0.0, 0.2]).collect();
        let rounded = slow.iter().map(|tip| tip.map(|x| (x / 2e-3).round() * 2e-3)).collect();
        measured.tip_m = Some(rounded);
        let moved: Vec<[f64; 3]> = slow.iter().map(|tip| [10.0 * tip[0], 0.0, 0.2]).collect();
        assert!(Exclusions::find(&measured, &moved).frozen.is_empty());
    }
}
