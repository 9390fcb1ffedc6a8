//! Interpolation of a body's pose between frames.

use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};

use crate::data::recording::Pose;
use crate::math::rotation;

/// Rounding of times in exports, seconds, and of sums of times.
const ROUNDING_S: f64 = 1e-6;
const SAME_TIME_S: f64 = 1e-9;

/// From the body's axes to those of the export.
fn motion(pose: &Pose) -> Isometry3<f64> {
    let [w, x, y, z] = pose.quaternion;
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Isometry3::from_parts(Vector3::from(pose.position_m).into(), rotation)
}

/// Linear interpolation of position, constant-rate interpolation of orientation.
fn between(from: &Isometry3<f64>, to: &Isometry3<f64>, share: f64) -> Isometry3<f64> {
    let place_m = from.translation.vector.lerp(&to.translation.vector, share);
    Isometry3::from_parts(place_m.into(), rotation::between(&from.rotation, &to.rotation, share))
}

/// The pose at a time, interpolated between the nearest tracked frames; `None` when these are more
/// than `max_gap_s` apart or the time lies outside the export.
pub(crate) fn pose_at(
    frames_s: &[f64],
    poses: &[Option<Pose>],
    time_s: f64,
    max_gap_s: f64,
) -> Option<Isometry3<f64>> {
    let (first_s, last_s) = (*frames_s.first()?, *frames_s.last()?);
    if time_s < first_s - ROUNDING_S || time_s > last_s + ROUNDING_S {
        return None;
    }
    let time_s = time_s.clamp(first_s, last_s);
    let gap_s = max_gap_s + ROUNDING_S;
    let next = frames_s.partition_point(|&frame_s| frame_s < time_s);
    let within_gap = |frame: &usize| (frames_s[*frame] - time_s).abs() <= gap_s;
    let tracked = |frame: usize| poses[frame].as_ref().map(|pose| (frames_s[frame], motion(pose)));
    let to = (next..frames_s.len()).take_while(within_gap).find_map(tracked);
    let from = (0..next).rev().take_while(within_gap).find_map(tracked);
    // A frame at this time needs no neighbour, on whichever side of it rounding has put the time.
    if let Some((_, pose)) = [to, from]
        .into_iter()
        .flatten()
        .find(|(frame_s, _)| (frame_s - time_s).abs() <= SAME_TIME_S)
    {
        return Some(pose);
    }
    let ((from_s, from), (to_s, to)) = (from?, to?);
    (to_s - from_s <= gap_s).then(|| between(&from, &to, (time_s - from_s) / (to_s - from_s)))
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
        let bridged = pose_at(&frames_s, &poses, 0.005, 0.02).unwrap();
        assert!(
            (bridged.translation.x - 0.5).abs() < 1e-12
                && (bridged.rotation.angle() - 3.1).abs() < 1e-12
        );
        assert_eq!(pose_at(&frames_s, &poses, 0.005, 0.019), None);
        assert_eq!(
            pose_at(&frames_s, &poses, 0.02, 0.001).unwrap().translation.x,
            2.0,
            "a frame needs no neighbour"
        );
        assert_eq!(
            pose_at(&frames_s, &poses, 0.02 + 1e-12, 0.001).unwrap().translation.x,
            2.0,
            "a sum of times is rounded"
        );
        assert_eq!(
            pose_at(&frames_s, &poses, 0.04 + 5e-7, 0.05).unwrap().translation.x,
            4.0,
            "rounded times"
        );
        assert!(
            pose_at(&frames_s, &poses, -0.01, 1.0).is_none()
                && pose_at(&frames_s, &poses, 0.05, 1.0).is_none()
        );
        assert!(
            pose_at(&frames_s, &[None; 5], 0.01, 1.0).is_none()
                && pose_at(&[], &[], 0.0, 1.0).is_none()
        );
        assert!(pose_at(&frames_s, &poses, f64::NAN, 1.0).is_none());
    }
}
