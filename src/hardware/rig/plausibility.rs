//! Holds the robot while the measured tip is implausible: too fast, or too far from the predicted one.

use super::Rig;
use super::stop_reasons::implausible;
use crate::base::distance_m;
use crate::hardware::safety::StopReason;

impl Rig {
    /// Why the latest tip position is implausible; none while it is plausible.
    pub(super) fn implausible_tip(&mut self) -> Option<StopReason> {
        let limits = self.parts.limits;
        let pose = self.parts.tracking.latest()?;
        let (time_s, tip_m) = (pose.time_s, pose.position_m);
        if let Some((then_s, there_m)) = self.last_plausible.filter(|(then_s, _)| *then_s < time_s) {
            let speed_m_s = distance_m(&tip_m, &there_m) / (time_s - then_s);
            if speed_m_s > limits.tip_speed_m_s {
                return Some(implausible(format!(
                    "measured tip speed {speed_m_s:.1} m/s, expected at most {}",
                    limits.tip_speed_m_s
                )));
            }
        }
        if let Some(expected_m) = &self.expected_m {
            let off_m = distance_m(&tip_m, expected_m);
            if off_m > limits.tip_from_model_m {
                return Some(implausible(format!(
                    "the measured tip is {off_m:.3} m from the predicted one, expected at most {} m",
                    limits.tip_from_model_m
                )));
            }
        }
        self.last_plausible = Some((time_s, tip_m));
        None
    }
}
