//! What markers on the base say: whether the base is tilted or the tracking frame turned, which look alike at the tip.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::data::Recording;
use crate::effects::Model;
use crate::math::summary::{mean, standard_deviation};

/// Markers on a base show how it stands to no better than this, radians.
const MOUNTED_RAD: f64 = 2e-3;
/// Standard deviations beyond which a tilt may be there.
const SEEN: f64 = 1.5;

/// Whether markers on the base, where there are any, show it standing as in the `model`: then nothing at the tip is its tilt.
pub(super) fn stands_as_modelled(measured: &Recording, model: &Model) -> bool {
    let Some(base) = &measured.base else { return false };
    let modelled = UnitQuaternion::from_scaled_axis(model.rod(&[]).base_rotation_rad);
    let tracked = base.iter().filter(|pose| pose.quaternion.iter().all(|q| q.is_finite()));
    let turns: Vec<Vector3<f64>> = tracked
        .map(|pose| {
            let [w, x, y, z] = pose.quaternion;
            (UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)) * modelled.inverse()).scaled_axis()
        })
        .collect();
    let stands = |axis: usize| {
        let about: Vec<f64> = turns.iter().map(|turn| turn[axis]).collect();
        let deviation = MOUNTED_RAD.hypot(standard_deviation(&about) / (about.len() as f64).sqrt());
        mean(&about).abs() < SEEN * deviation
    };
    turns.len() > 1 && (0..2).all(stands)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Actuation;
    use crate::data::recording::Pose;

    /// A recording in which the base is turned by so much, as its markers have it.
    fn turned(turn_rad: [f64; 3]) -> Recording {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::from(turn_rad));
        let pose = Pose { position_m: [0.0; 3], quaternion: [turn.w, turn.i, turn.j, turn.k] };
        Recording { base: Some(vec![pose; 5]), ..Recording::new(Actuation::Lengths, 4) }
    }

    #[test]
    fn a_base_is_compared_with_that_of_the_model() {
        let mut model = Model::default();
        assert!(!stands_as_modelled(&Recording::new(Actuation::Lengths, 4), &model), "nobody looked");
        let tilted = [0.0, 0.025, 0.3];
        assert!(stands_as_modelled(&turned([0.0, 0.001, 0.0]), &model));
        assert!(!stands_as_modelled(&turned(tilted), &model));
        assert!(!stands_as_modelled(&turned([0.005, 0.0, 0.0]), &model));
        model.robot.base_rotation_rad = tilted;
        assert!(stands_as_modelled(&turned(tilted), &model));
        assert!(!stands_as_modelled(&turned([0.0; 3]), &model), "the tilt is the model's alone");
    }
}
