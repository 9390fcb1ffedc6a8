//! What markers on the base say: whether the base is tilted or the tracking frame turned, which look alike at the tip.

use nalgebra::{Quaternion, UnitQuaternion};

use crate::data::Recording;
use crate::math::summary::{mean, standard_deviation};

/// Markers on a base stand no straighter than this, radians.
const MOUNTED_RAD: f64 = 2e-3;
/// Standard deviations beyond which a tilt is seen.
const SEEN: f64 = 3.0;

/// Whether markers on the base, where there are any, show it standing straight: then nothing at the tip is its tilt.
pub(super) fn stands_straight(measured: &Recording) -> bool {
    let Some(base) = &measured.base else { return false };
    let tracked = base.iter().filter(|pose| pose.quaternion.iter().all(|q| q.is_finite()));
    let turns: Vec<[f64; 2]> = tracked
        .map(|pose| {
            let [w, x, y, z] = pose.quaternion;
            let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).scaled_axis();
            [turn.x, turn.y]
        })
        .collect();
    let straight = |axis: usize| {
        let about: Vec<f64> = turns.iter().map(|turn| turn[axis]).collect();
        let deviation = MOUNTED_RAD.hypot(standard_deviation(&about) / (about.len() as f64).sqrt());
        mean(&about).abs() < SEEN * deviation
    };
    turns.len() > 1 && (0..2).all(straight)
}
