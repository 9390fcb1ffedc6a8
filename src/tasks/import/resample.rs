//! A body's pose between the frames.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::data::motive::Pose;

/// Exports round their times to this, seconds.
const ROUNDING_S: f64 = 1e-6;

/// A place and a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placed {
    /// Metres.
    pub(super) position_m: Vector3<f64>,
    pub(super) turn: UnitQuaternion<f64>,
}

impl Placed {
    fn of(pose: &Pose) -> Placed {
        let [w, x, y, z] = pose.quaternion;
        Placed {
            position_m: Vector3::from(pose.position_m),
            turn: UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
        }
    }

    /// On the straight line between two, turning evenly.
    fn between(from: &Placed, to: &Placed, share: f64) -> Placed {
        // Half a turn between two frames has no way of its own: then the nearer one.
        let nearer = if share < 0.5 { from.turn } else { to.turn };
        Placed {
            position_m: from.position_m.lerp(&to.position_m, share),
            turn: from.turn.try_slerp(&to.turn, share, 1e-12).unwrap_or(nearer),
        }
    }
}

/// The pose at a time, from the frames next to it in which the body was tracked; none when these are more than
/// `max_gap_s` apart, or the time lies outside the export.
pub(super) fn at(frames_s: &[f64], poses: &[Option<Pose>], time_s: f64, max_gap_s: f64) -> Option<Placed> {
    let (first_s, last_s) = (*frames_s.first()?, *frames_s.last()?);
    if time_s < first_s - ROUNDING_S || time_s > last_s + ROUNDING_S {
        return None;
    }
    let time_s = time_s.clamp(first_s, last_s);
    let gap_s = max_gap_s + ROUNDING_S;
    let middle = frames_s.partition_point(|&frame_s| frame_s < time_s);
    let near = |frame: &usize| (frames_s[*frame] - time_s).abs() <= gap_s;
    let tracked = |frame: usize| poses[frame].as_ref().map(|pose| (frames_s[frame], Placed::of(pose)));
    let (to_s, to) = (middle..frames_s.len()).take_while(near).find_map(tracked)?;
    if to_s == time_s {
        return Some(to);
    }
    let (from_s, from) = (0..middle).rev().take_while(near).find_map(tracked)?;
    (to_s - from_s <= gap_s).then(|| Placed::between(&from, &to, (time_s - from_s) / (to_s - from_s)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(x_m: f64, turn_rad: f64) -> Option<Pose> {
        let (sine, cosine) = (0.5 * turn_rad).sin_cos();
        Some(Pose { position_m: [x_m, 0.0, 0.0], quaternion: [cosine, 0.0, 0.0, sine] })
    }

    #[test]
    fn a_gap_is_bridged_up_to_its_limit_and_the_short_way_round() {
        let frames_s = [0.0, 0.01, 0.02, 0.03, 0.04];
        let poses = [pose(0.0, 3.0), None, pose(2.0, 3.4), None, pose(4.0, 0.0)];
        let bridged = at(&frames_s, &poses, 0.005, 0.02).unwrap();
        assert!((bridged.position_m.x - 0.5).abs() < 1e-12 && (bridged.turn.angle() - 3.1).abs() < 1e-12);
        assert_eq!(at(&frames_s, &poses, 0.005, 0.019), None);
        assert_eq!(at(&frames_s, &poses, 0.02, 0.001).unwrap().position_m.x, 2.0, "a frame needs no neighbour");
        assert_eq!(at(&frames_s, &poses, 0.04 + 5e-7, 0.05).unwrap().position_m.x, 4.0, "rounded times");
        assert!(at(&frames_s, &poses, -0.01, 1.0).is_none() && at(&frames_s, &poses, 0.05, 1.0).is_none());
        assert!(at(&frames_s, &[None; 5], 0.01, 1.0).is_none() && at(&[], &[], 0.0, 1.0).is_none());
        assert!(at(&frames_s, &poses, f64::NAN, 1.0).is_none());
    }
}
