//! What the robot is held for until it is over.

use super::Rig;
use super::stop_reasons::{ARM, implausible, tracking_lost};
use crate::base::{Point3, distance_m};
use crate::hardware::axes::AXES;
use crate::hardware::safety::StopReason;

/// A pose that does not change is frozen after this time, s,
const FROZEN_S: f64 = 0.05;
/// if a screw has moved by more than this since, mm,
const FROZEN_MM: f64 = 1.0;
/// and the model's tip by more than this, metres: noise and dry friction hide less.
const FROZEN_TIP_M: f64 = 0.005;

/// What things were like when the tracker's pose last changed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LastPoseChange {
    /// Changes so far.
    count: u64,
    /// Where the screws stood, mm.
    position_mm: [f64; AXES],
    /// Where the model put the tip, metres.
    expected_m: Option<Point3>,
}

impl Rig {
    /// Why the robot should not go on for now: a controller that owes an answer, or a measurement that is not to be used.
    pub(crate) fn hold_reason(&mut self, now_s: f64) -> Option<StopReason> {
        let waiting_s = self.parts.controller.waiting_s(now_s);
        if waiting_s > self.parts.late_s {
            let what = format!("the controller has owed an answer for {:.0} ms", waiting_s * 1e3);
            return Some(StopReason { kind: "controller", what, remedy: ARM.to_owned() });
        }
        let limits = self.parts.limits;
        let age_s = self.parts.tracking.age_s(now_s);
        if age_s.is_nan() || age_s > limits.tracking_hold_s {
            return Some(tracking_lost(age_s, limits.tracking_hold_s, self.parts.tracking.status()));
        }
        if let Some(reason) = self.frozen_tracking() {
            return Some(reason);
        }
        let pose = self.parts.tracking.latest()?;
        let (time_s, tip_m) = (pose.time_s, pose.position_m);
        if let Some((then_s, there_m)) = self.last_plausible.filter(|(then_s, _)| *then_s < time_s) {
            let speed_m_s = distance_m(&tip_m, &there_m) / (time_s - then_s);
            if speed_m_s > limits.tip_speed_m_s {
                return Some(implausible(format!(
                    "the tip seems to move at {speed_m_s:.1} m/s, expected at most {}",
                    limits.tip_speed_m_s
                )));
            }
        }
        if let Some(expected_m) = &self.expected_m {
            let off_m = distance_m(&tip_m, expected_m);
            if off_m > limits.tip_from_model_m {
                return Some(implausible(format!(
                    "the tip is measured {off_m:.3} m from where the model puts it, expected at most {} m",
                    limits.tip_from_model_m
                )));
            }
        }
        self.last_plausible = Some((time_s, tip_m));
        None
    }

    /// A tracker that sends one pose for ever, with new time stamps, while motors and model have gone on.
    fn frozen_tracking(&mut self) -> Option<StopReason> {
        let (status, position_mm) = (self.parts.tracking.status(), self.parts.controller.state().position_mm);
        if status.changes != self.last_pose_change.count {
            self.last_pose_change = LastPoseChange { count: status.changes, position_mm, expected_m: self.expected_m };
            return None;
        }
        let (Some(from_m), Some(to_m)) = (self.last_pose_change.expected_m, self.expected_m) else {
            self.last_pose_change.expected_m = self.expected_m;
            return None;
        };
        let turned_mm = position_mm.iter().zip(&self.last_pose_change.position_mm).map(|(to, from)| (to - from).abs());
        let turned_mm = turned_mm.fold(0.0, f64::max);
        let unchanged_s = status.unchanged_s;
        let frozen_tracking =
            unchanged_s >= FROZEN_S && turned_mm > FROZEN_MM && distance_m(&from_m, &to_m) > FROZEN_TIP_M;
        frozen_tracking.then(|| StopReason {
            kind: "tracking",
            what: format!(
                "the tracker has sent the same pose to the last bit for {:.0} ms while a screw moved by {turned_mm:.1} mm: \
                 it no longer measures",
                unchanged_s * 1e3
            ),
            remedy: "start its streaming anew and check with `spinebench doctor`, then `spinebench arm --plant PLANT.yaml`"
                .to_owned(),
        })
    }
}
