//! Base markers: they tell a tilted base from a rotated tracking frame, which look alike at the
//! tip.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::data::Recording;
use crate::effects::Model;
use crate::math::summary::{mean, standard_deviation};

/// Accuracy of base markers, radians.
const MOUNTING_ACCURACY_RAD: f64 = 2e-3;
/// Tilts beyond this many standard deviations are considered possible.
const MAX_DEVIATIONS: f64 = 1.5;

/// Whether base markers in these `rows` show the base pose of the `model`, apart from rotation
/// about its own axis. If they do, no tip error is a base tilt. False without markers.
pub(crate) fn base_matches_model(measured: &Recording, rows: &[usize], model: &Model) -> bool {
    let Some(base) = &measured.base else { return false };
    let modelled = UnitQuaternion::from_scaled_axis(model.rod(&[]).base_rotation_rad);
    let poses = rows.iter().map(|&row| &base[row]);
    let tracked = poses.filter(|pose| pose.quaternion.iter().all(|q| q.is_finite()));
    let turns: Vec<Vector3<f64>> = tracked
        .map(|pose| {
            let [w, x, y, z] = pose.quaternion;
            // In the base's own frame, where its axis is z and turns about it may be left out.
            (modelled.inverse() * UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)))
                .scaled_axis()
        })
        .collect();
    let is_straight = |axis: usize| {
        let about: Vec<f64> = turns.iter().map(|turn| turn[axis]).collect();
        // Mounting and noise are independent; the mean averages noise alone.
        let deviation =
            MOUNTING_ACCURACY_RAD.hypot(standard_deviation(&about) / (about.len() as f64).sqrt());
        mean(&about).abs() < MAX_DEVIATIONS * deviation
    };
    // Markers are seldom mounted at a known angle about the base's own axis.
    turns.len() > 1 && (0..2).all(is_straight)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Actuation;
    use crate::data::recording::Pose;

    /// Rows of the first trial of a recording.
    const FIRST_TRIAL: [usize; 3] = [0, 1, 2];

    /// A recording whose base markers show this rotation.
    fn turned(turn_rad: [f64; 3]) -> Recording {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::from(turn_rad));
        let pose = Pose { position_m: [0.0; 3], quaternion: [turn.w, turn.i, turn.j, turn.k] };
        let trial = vec![0, 0, 0, 1, 1];
        Recording { base: Some(vec![pose; 5]), trial, ..Recording::new(Actuation::Lengths, 4) }
    }

    #[test]
    fn a_base_is_compared_with_that_of_the_model() {
        let mut model = Model::default();
        let stands =
            |measured: &Recording, model: &Model| base_matches_model(measured, &FIRST_TRIAL, model);
        assert!(!stands(&Recording::new(Actuation::Lengths, 4), &model), "nobody looked");
        let tilted = [0.0, 0.025, 0.3];
        assert!(stands(&turned([0.0, 0.001, 0.0]), &model));
        assert!(!stands(&turned(tilted), &model));
        assert!(!stands(&turned([0.005, 0.0, 0.0]), &model));
        model.robot.base_rotation_rad = tilted;
        assert!(stands(&turned(tilted), &model));
        assert!(!stands(&turned([0.0; 3]), &model), "the tilt is the model's alone");
    }

    /// A robot that lies along x is tilted by a rotation about z, not by one about x.
    #[test]
    fn a_lying_base_is_tilted_about_its_own_axes() {
        let mut model = Model::default();
        let lying = UnitQuaternion::from_scaled_axis(Vector3::y() * std::f64::consts::FRAC_PI_2);
        model.robot.base_rotation_rad = lying.scaled_axis().into();
        let about = |axis: Vector3<f64>| {
            (UnitQuaternion::from_scaled_axis(axis * 0.1) * lying).scaled_axis().into()
        };
        assert!(base_matches_model(&turned(about(Vector3::x())), &FIRST_TRIAL, &model));
        assert!(!base_matches_model(&turned(about(Vector3::z())), &FIRST_TRIAL, &model));
    }

    #[test]
    fn trials_that_are_held_out_have_no_say() {
        let mut measured = turned([0.0; 3]);
        let aside = turned([0.1, 0.0, 0.0]).base.unwrap();
        measured.base.as_mut().unwrap()[3..].clone_from_slice(&aside[3..]);
        assert!(base_matches_model(&measured, &FIRST_TRIAL, &Model::default()));
        assert!(!base_matches_model(&measured, &[3, 4], &Model::default()));
    }
}
