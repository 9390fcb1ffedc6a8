//! Holds the robot when tracking is lost: no valid pose for `tracking_hold_s`, many lost frames,
//! two sources of frames, or a tracker that repeats one pose.
//!
//! The reason goes to the guard (`safety/guard.rs`), which holds the robot at once and stops it
//! after `hold_stop_s`.

use super::Rig;
use crate::base::{Point3, distance_m};
use crate::hardware::axes::AXES;
use crate::hardware::safety::StopReason;
use crate::hardware::tracking::TrackingStatus;

/// An unchanged pose counts as frozen after this time, s,
const MIN_FROZEN_S: f64 = 0.05;
/// if a screw has moved by more than this meanwhile, mm,
const MIN_FROZEN_TURN_MM: f64 = 1.0;
/// and the predicted tip by more than this, metres: noise and dry friction hide less.
const MIN_FROZEN_TIP_M: f64 = 0.005;

/// Time after a frame of a second source during which the robot is held, s.
const SECOND_SOURCE_S: f64 = 0.5;

/// Largest share of frames that may be lost: beyond it, gaps of `tracking_hold_s` are a matter of
/// seconds.
const MAX_LOSS: f64 = 0.25;

/// State when the tracker's pose last changed.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LastPoseChange {
    /// Number of changes so far.
    count: u64,
    /// Screw positions, mm.
    position_mm: [f64; AXES],
    /// Tip position that the model predicted, metres.
    expected_m: Option<Point3>,
}

impl Rig {
    /// Why tracking counts as lost; none while it works.
    pub(super) fn tracking_loss(&mut self, now_s: f64) -> Option<StopReason> {
        let status = self.parts.tracking.status();
        // First, because the poses are old as well once only the other source streams.
        if let Some((then_s, difference)) = &status.second_source_last
            && now_s - then_s <= SECOND_SOURCE_S
        {
            return Some(second_source(difference));
        }
        let hold_s = self.parts.limits.tracking_hold_s;
        let age_s = self.parts.tracking.age_s(now_s);
        // An age that is not a number must hold, too.
        if age_s.is_nan() || age_s > hold_s {
            return Some(old_pose(age_s, hold_s, status));
        }
        if let Some(share) = status.recent_loss.filter(|share| *share > MAX_LOSS) {
            return Some(many_lost(share));
        }
        self.frozen_tracking().or_else(|| self.tip_at_rest(now_s))
    }

    /// A tracker that repeats one pose with new time stamps while the motors and the model move.
    fn frozen_tracking(&mut self) -> Option<StopReason> {
        let (status, position_mm) =
            (self.parts.tracking.status(), self.parts.controller.state().position_mm);
        if status.changes != self.last_pose_change.count {
            self.last_pose_change =
                LastPoseChange { count: status.changes, position_mm, expected_m: self.expected_m };
            return None;
        }
        // Without a prediction the tip may well stand still.
        let (Some(from_m), Some(to_m)) = (self.last_pose_change.expected_m, self.expected_m) else {
            self.last_pose_change.expected_m = self.expected_m;
            return None;
        };
        let turned_mm = position_mm
            .iter()
            .zip(&self.last_pose_change.position_mm)
            .map(|(to, from)| (to - from).abs());
        let turned_mm = turned_mm.fold(0.0, f64::max);
        let unchanged_s = status.unchanged_s;
        let frozen = unchanged_s >= MIN_FROZEN_S
            && turned_mm > MIN_FROZEN_TURN_MM
            && distance_m(&from_m, &to_m) > MIN_FROZEN_TIP_M;
        frozen.then(|| {
            tracking(
                format!(
                    "the tracker has repeated one pose for {:.0} ms while a screw moved by \
                     {turned_mm:.1} mm: its measurement has stopped",
                    unchanged_s * 1e3
                ),
                "restart its streaming and check it with `spinebench doctor`",
            )
        })
    }
}

/// A reason of this kind, with its remedy before arming.
pub(super) fn tracking(what: String, remedy: &str) -> StopReason {
    StopReason {
        kind: "tracking",
        what,
        remedy: format!("{remedy}, then run `spinebench arm --plant PLANT.yaml`"),
    }
}

fn second_source(found: &str) -> StopReason {
    let what = format!("two sources stream frames to this computer: {found}");
    tracking(what, "stop one of the two servers and check the other with `spinebench doctor`")
}

fn many_lost(share: f64) -> StopReason {
    let what = format!(
        "{:.0} % of the tracker's last 256 frames are lost, expected at most {:.0} %",
        100.0 * share,
        100.0 * MAX_LOSS
    );
    tracking(
        what,
        "check the network between the tracker and this computer (a cable instead of a radio link)",
    )
}

/// The reason for a pose that is too old.
fn old_pose(age_s: f64, allowed_s: f64, status: &TrackingStatus) -> StopReason {
    let aged = || format!("tracking lost: the last valid pose is {:.0} ms old", age_s * 1e3);
    let found =
        if age_s.is_finite() { aged() } else { "tracking lost: no valid pose so far".to_owned() };
    let stranger = || {
        let from = status.foreign_source?;
        Some(format!("{} datagrams from {from}, which is not the server", status.foreign))
    };
    let unseen = || status.unseen.map(str::to_owned);
    let why = status
        .fault
        .clone()
        .or_else(unseen)
        .or_else(stranger)
        .or_else(|| status.socket_error.clone());
    let why = why.map(|why| format!(" ({why})")).unwrap_or_default();
    let what = format!("{found}, expected at most {:.0} ms{why}", allowed_s * 1e3);
    tracking(what, "make both bodies visible and check that Motive streams")
}
