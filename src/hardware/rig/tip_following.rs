//! Holds the robot while the tip stays where it is although the screws and the predicted tip move:
//! a tracker that goes on with an old pose and its noise, a marker body that has come off, or a
//! robot that is stuck.

use std::collections::VecDeque;

use super::Rig;
use super::tracking_loss::tracking;
use crate::base::{Point3, distance_m};
use crate::hardware::axes::AXES;
use crate::hardware::grbl::AXIS_NAMES;
use crate::hardware::safety::StopReason;

/// Poses whose mean is compared, which averages their noise.
const AVERAGED_POSES: usize = 10;
/// Distance of two means that counts as motion, metres, in addition to three standard deviations of
/// the noise.
const MIN_MOTION_M: f64 = 0.0015;
const NOISE_DEVIATIONS: f64 = 3.0;
/// The tip is at rest if, meanwhile, a screw has moved by more than this, mm: more than backlash,
const MIN_TURNED_MM: f64 = 3.0;
/// the predicted tip by more than this, metres,
const MIN_PREDICTED_M: f64 = 0.01;
/// and by more than this multiple of what counts as motion,
const MIN_PREDICTED_MULTIPLE: f64 = 3.0;
/// for this long, s: a robot follows with a delay.
const MIN_REST_S: f64 = 0.3;
/// Weight of the newest pose in the running estimate of the noise.
const NEWEST_WEIGHT: f64 = 1.0 / 32.0;
/// Second differences of a series with independent noise of variance 1 on each of three axes have
/// this mean square: 3 · (1 + 4 + 1).
const SECOND_DIFFERENCE_SQUARE: f64 = 18.0;

/// Where the tip, its prediction and the screws were when the tip last moved.
#[derive(Clone, Copy, Debug)]
struct Anchor {
    tip_m: Point3,
    expected_m: Point3,
    position_mm: [f64; AXES],
}

/// How far a tip at rest, its prediction and the screws have moved.
#[derive(Clone, Copy, Debug)]
struct Unfollowed {
    moved_m: f64,
    predicted_m: f64,
    turned_mm: [f64; AXES],
}

impl Unfollowed {
    /// The screws that have moved, such as "X by 6.0 mm".
    fn screws(&self) -> String {
        let each = AXIS_NAMES
            .iter()
            .zip(&self.turned_mm)
            .filter(|(_, turned_mm)| **turned_mm > MIN_TURNED_MM);
        each.map(|(name, turned_mm)| format!("{name} by {turned_mm:.1} mm"))
            .collect::<Vec<String>>()
            .join(", ")
    }
}

/// State of the comparison.
#[derive(Clone, Debug, Default)]
pub(super) struct TipFollowing {
    recent_m: VecDeque<Point3>,
    last_time_s: f64,
    /// Variance of the noise on an axis, square metres.
    noise_m2: f64,
    anchor: Option<Anchor>,
    /// Since when the tip should have moved, s.
    since_s: Option<f64>,
}

impl TipFollowing {
    /// Adds a pose.
    fn push(&mut self, time_s: f64, tip_m: Point3) {
        self.last_time_s = time_s;
        if self.recent_m.len() == AVERAGED_POSES {
            self.recent_m.pop_front();
        }
        self.recent_m.push_back(tip_m);
        if let [.., a, b, c] = self.recent_m.make_contiguous() {
            // Second differences cancel a steady motion and leave noise.
            let square: f64 = (0..3).map(|axis| (c[axis] - 2.0 * b[axis] + a[axis]).powi(2)).sum();
            self.noise_m2 += NEWEST_WEIGHT * (square / SECOND_DIFFERENCE_SQUARE - self.noise_m2);
        }
    }

    /// Mean of the recent poses; none before there are enough.
    fn mean_m(&self) -> Option<Point3> {
        let mean = |axis: usize| {
            self.recent_m.iter().map(|tip_m| tip_m[axis]).sum::<f64>() / AVERAGED_POSES as f64
        };
        (self.recent_m.len() == AVERAGED_POSES).then(|| [0, 1, 2].map(mean))
    }

    /// Distance of two means that counts as motion, metres.
    fn moved_m(&self) -> f64 {
        // Variance of the difference of two means, over three axes.
        let of_difference = 3.0 * 2.0 * self.noise_m2 / AVERAGED_POSES as f64;
        MIN_MOTION_M + NOISE_DEVIATIONS * of_difference.sqrt()
    }

    /// Compares the tip with its prediction and the screws; returns how far each has moved once the
    /// tip has been at rest for too long.
    fn compare(
        &mut self,
        expected_m: Point3,
        position_mm: [f64; AXES],
        now_s: f64,
    ) -> Option<Unfollowed> {
        let tip_m = self.mean_m()?;
        let current = Anchor { tip_m, expected_m, position_mm };
        let anchor = *self.anchor.get_or_insert(current);
        let (moved_m, min_motion_m) = (distance_m(&tip_m, &anchor.tip_m), self.moved_m());
        if moved_m > min_motion_m {
            // The tip follows: measure from here.
            (self.anchor, self.since_s) = (Some(current), None);
            return None;
        }
        let predicted_m = distance_m(&expected_m, &anchor.expected_m);
        let turned_mm: [f64; AXES] =
            std::array::from_fn(|axis| (position_mm[axis] - anchor.position_mm[axis]).abs());
        // A rest is suspicious only if both screws and model have moved enough to show.
        if turned_mm.iter().all(|turned_mm| *turned_mm <= MIN_TURNED_MM)
            || predicted_m <= MIN_PREDICTED_M.max(MIN_PREDICTED_MULTIPLE * min_motion_m)
        {
            self.since_s = None;
            return None;
        }
        let since_s = *self.since_s.get_or_insert(now_s);
        (now_s - since_s >= MIN_REST_S).then_some(Unfollowed { moved_m, predicted_m, turned_mm })
    }
}

impl Rig {
    /// Why the tip counts as at rest; none while it follows.
    pub(super) fn tip_at_rest(&mut self, now_s: f64) -> Option<StopReason> {
        if let Some(pose) = self.parts.tracking.latest()
            && pose.time_s > self.tip_following.last_time_s
        {
            self.tip_following.push(pose.time_s, pose.position_m);
        }
        let Some(expected_m) = self.expected_m else {
            (self.tip_following.anchor, self.tip_following.since_s) = (None, None);
            return None;
        };
        let position_mm = self.parts.controller.state().position_mm;
        let unfollowed = self.tip_following.compare(expected_m, position_mm, now_s)?;
        Some(tracking(
            format!(
                "the measured tip has moved by {:.1} mm while the axes moved ({}) and the \
                 predicted tip by {:.1} mm: the tracker repeats an old pose, its body has come \
                 off, a motor does not turn its screw, or the robot is stuck",
                unfollowed.moved_m * 1e3,
                unfollowed.screws(),
                unfollowed.predicted_m * 1e3
            ),
            "check the tip's body, the motors and the tendons with `spinebench doctor --move`",
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;
    use rand::RngExt;

    /// A tip at `tip_m(time)` with noise, while the screws and the prediction move at 15 mm/s and
    /// 80 mm/s; the time of the first finding, s.
    fn found_s(noise_m: f64, tip_m: impl Fn(f64) -> f64) -> Option<f64> {
        let mut random = Seed(3).rng();
        let mut following = TipFollowing::default();
        (0..500).find_map(|k| {
            let time_s = 0.01 * f64::from(k);
            let noise: [f64; 3] =
                std::array::from_fn(|_| noise_m * 3.46 * (random.random::<f64>() - 0.5));
            following.push(time_s, [tip_m(time_s) + noise[0], noise[1], noise[2]]);
            let travel_s = (time_s - 1.0).clamp(0.0, 2.0);
            following
                .compare([0.08 * travel_s, 0.0, 0.0], [15.0 * travel_s, 0.0, 0.0, 0.0], time_s)
                .map(|_| time_s)
        })
    }

    #[test]
    fn a_tip_at_rest_is_told_from_one_that_follows_whatever_its_noise() {
        for noise_m in [0.0, 2e-5, 2e-4, 5e-4, 1e-3] {
            let found = found_s(noise_m, |_| 0.2);
            assert!(
                found.is_some_and(|time_s| (1.4..2.0).contains(&time_s)),
                "{noise_m}: {found:?}"
            );
            for (gain, delay_s) in [(1.0, 0.0), (0.2, 0.1), (0.5, 0.3)] {
                let follows = |time_s: f64| gain * 0.08 * (time_s - 1.0 - delay_s).clamp(0.0, 2.0);
                assert_eq!(found_s(noise_m, follows), None, "{noise_m} {gain} {delay_s}");
            }
        }
    }
}
