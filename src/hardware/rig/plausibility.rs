//! Holds the robot while the measured tip is implausible: it has jumped, or is too far from the
//! predicted one.

use super::Rig;
use super::stop_reasons::implausible;
use crate::base::{Point3, distance_m};
use crate::hardware::safety::{GuardState, StopReason};
use crate::hardware::tracking::TipPose;

/// Share of a jump that has to be undone before the tip is plausible again: the robot is held
/// meanwhile, so that a tip that stays away has not moved but is measured elsewhere.
const UNDONE_SHARE: f64 = 0.5;

/// A tip that moved faster than it can.
#[derive(Clone, Copy, Debug)]
pub(super) struct TipJump {
    from_m: Point3,
    by_m: f64,
    within_s: f64,
}

impl TipJump {
    fn describe(&self, most_m_s: f64) -> String {
        format!(
            "the measured tip jumped by {:.0} mm within {:.0} ms ({:.1} m/s, expected at most \
             {most_m_s}): its body has moved on the tip, or another body was tracked in its place",
            self.by_m * 1e3,
            self.within_s * 1e3,
            self.by_m / self.within_s
        )
    }
}

impl Rig {
    /// Why the latest tip position is implausible; none while it is plausible.
    pub(super) fn implausible_tip(&mut self) -> Option<StopReason> {
        // Hands may move the tip of a robot that is not active.
        if !matches!(self.guard.state(), GuardState::Active | GuardState::Held { .. }) {
            (self.last_plausible, self.jump) = (None, None);
            return None;
        }
        let limits = self.parts.limits;
        let pose = self.parts.tracking.latest()?;
        let (pose, tip_m) = (*pose, pose.position_m);
        // A jump is over once the tip is back near where it came from.
        self.jump =
            self.jump.filter(|jump| distance_m(&tip_m, &jump.from_m) > UNDONE_SHARE * jump.by_m);
        if let Some(last) = self.last_plausible {
            let (by_m, within_s) =
                (distance_m(&tip_m, &last.position_m), time_between_s(&last, &pose));
            if within_s > 0.0 && by_m > limits.tip_speed_m_s * within_s {
                // The first jump counts; later ones would hide where the tip came from.
                self.jump.get_or_insert(TipJump { from_m: last.position_m, by_m, within_s });
            }
        }
        if let Some(jump) = &self.jump {
            return Some(implausible(jump.describe(limits.tip_speed_m_s)));
        }
        if let Some(expected_m) = &self.expected_m {
            let off_m = distance_m(&tip_m, expected_m);
            if off_m > limits.tip_from_model_m {
                return Some(implausible(format!(
                    "the measured tip is {off_m:.3} m from the predicted one, expected at most {} \
                     m",
                    limits.tip_from_model_m
                )));
            }
        }
        self.last_plausible = Some(pose);
        None
    }
}

/// Time from pose to pose, s, by the tracker's clock: local times may belong to two estimates of
/// the clock offset, which falls when a frame is less delayed than all before. A tracker that has
/// restarted counts from zero, so that local times have to serve.
fn time_between_s(first: &TipPose, second: &TipPose) -> f64 {
    f64::max(second.stamp_s - first.stamp_s, second.time_s - first.time_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(stamp_s: f64, time_s: f64) -> TipPose {
        TipPose { stamp_s, time_s, position_m: [0.0; 3], quaternion: [1.0, 0.0, 0.0, 0.0] }
    }

    #[test]
    fn a_better_clock_offset_makes_no_jump() {
        // The offset falls by 0.29 s: a tip that took 0.3 s would seem to have taken 0.01 s.
        assert!((time_between_s(&pose(5.0, 1.3), &pose(5.3, 1.31)) - 0.3).abs() < 1e-12);
        // A tracker that has restarted.
        assert!((time_between_s(&pose(500.0, 1.3), &pose(0.1, 1.8)) - 0.5).abs() < 1e-12);
    }
}
