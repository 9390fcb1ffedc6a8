//! `models/trunk.yaml` against a run of the robot that it describes (tests/reference/trunk).

use nalgebra::{DMatrix, DVector, Vector3};
use spinebench::effects::{EffectSpec, Model, PerTendon};
use spinebench::math::optimise::least_squares::fit;
use spinebench::rod::{Drive, Rod, SolveStatus};

/// Rows of the excerpt that the model was fitted to.
const FITTED: usize = 63;
/// Tendon taken in per servo angle, m/rad.
const GAINS: [f64; 6] = [0.03143, 0.03599, 0.01759, 0.0333, 0.01861, 0.03611];
/// Tracked points beyond the centres of their disks, metres.
const MARKERS: [f64; 3] = [0.00281, -0.00849, 0.0];
const DISKS: [f64; 3] = [0.105, 0.21, 0.315];

/// One pose.
struct Pose {
    angles_rad: [f64; 6],
    disks_m: [Vector3<f64>; 3],
}

fn poses(name: &str) -> Vec<Pose> {
    let pose = |row: &std::collections::HashMap<String, f64>| Pose {
        angles_rad: [1, 2, 3, 4, 5, 6].map(|k| row[&format!("phi{k}")].to_radians()),
        disks_m: [1, 2, 3].map(|d| {
            Vector3::new(row[&format!("x{d}")], row[&format!("z{d}")], -row[&format!("y{d}")])
        }),
    };
    crate::support::rods::read(&format!("tests/reference/trunk/{name}.csv"))
        .iter()
        .map(pose)
        .collect()
}

/// The model and what stands beside it.
#[derive(Clone)]
struct Trunk {
    model: Model,
    gains: [f64; 6],
    markers_m: [f64; 3],
}

impl Trunk {
    fn shipped() -> Trunk {
        Trunk { model: crate::support::rods::model("trunk"), gains: GAINS, markers_m: MARKERS }
    }

    /// The sixteen fitted numbers, moved.
    fn moved(&self, by: &[f64]) -> Trunk {
        let mut trunk = self.clone();
        trunk.gains.iter_mut().zip(by).for_each(|(gain, log)| *gain *= log.exp());
        let robot = &mut trunk.model.robot;
        robot.base_m.iter_mut().zip(&by[6..9]).for_each(|(x, dx)| *x += 0.1 * dx);
        robot.base_rotation_rad.iter_mut().zip(&by[9..12]).for_each(|(x, dx)| *x += dx);
        trunk.markers_m.iter_mut().zip(&by[12..14]).for_each(|(x, dx)| *x += 0.1 * dx);
        let bending = robot.backbone.bending_stiffness_n_m2.expect("a measured stiffness");
        robot.backbone.bending_stiffness_n_m2 = Some(bending * by[14].exp());
        let scaled = |numbers: &PerTendon| PerTendon::Same(numbers.of(0) * by[15].exp());
        robot.tendons.compliance_m_per_n = scaled(&robot.tendons.compliance_m_per_n);
        robot.tendons.pretension_m = scaled(&robot.tendons.pretension_m);
        trunk
    }

    /// Disks at rest under the servo angles of each pose.
    fn predict(&self, poses: &[Pose], load_kg: f64) -> Option<Vec<[Vector3<f64>; 3]>> {
        let mut rod = Rod::new(self.model.rod(&[EffectSpec::tip_load(load_kg)]));
        let mut predicted = Vec::new();
        for pose in poses {
            let pull = |i: usize| pose.angles_rad[i / 2] * self.gains[i / 2] * [1.0, -1.0][i % 2];
            let drives: Vec<Drive> = (0..12).map(|i| Drive::Pull(pull(i))).collect();
            if rod.settle(&drives) != SolveStatus::Converged {
                return None;
            }
            predicted.push([0, 1, 2].map(|d| {
                let (centre, rotation) = rod.pose_at(DISKS[d]);
                centre + rotation * Vector3::z() * self.markers_m[d]
            }));
        }
        Some(predicted)
    }
}

fn rms_mm(predicted: &[[Vector3<f64>; 3]], poses: &[Pose]) -> [f64; 3] {
    std::array::from_fn(|d| {
        let sum: f64 = predicted
            .iter()
            .zip(poses)
            .map(|(disks, pose)| (disks[d] - pose.disks_m[d]).norm_squared())
            .sum();
        1e3 * (sum / poses.len() as f64).sqrt()
    })
}

/// A linear map from the servo angles, fitted to `train`.
fn linear(train: &[Pose], test: &[Pose]) -> Vec<[Vector3<f64>; 3]> {
    let matrix = |poses: &[Pose]| {
        DMatrix::from_fn(poses.len(), 7, |i, j| if j == 6 { 1.0 } else { poses[i].angles_rad[j] })
    };
    let solver = matrix(train).svd(true, true);
    let mut predicted = vec![[Vector3::zeros(); 3]; test.len()];
    for d in 0..3 {
        for axis in 0..3 {
            let seen =
                DVector::from_iterator(train.len(), train.iter().map(|pose| pose.disks_m[d][axis]));
            let column = matrix(test) * solver.solve(&seen, 1e-9).expect("a fit");
            predicted
                .iter_mut()
                .zip(column.iter())
                .for_each(|(disks, value)| disks[d][axis] = *value);
        }
    }
    predicted
}

#[test]
fn later_poses_are_predicted_better_than_by_a_linear_map() {
    let all = poses("0g_excerpt");
    let (train, test) = all.split_at(FITTED);
    let trunk = Trunk::shipped();
    let before = rms_mm(&trunk.predict(train, 0.0).expect("every pose is at rest"), train);
    let held_out = rms_mm(&trunk.predict(test, 0.0).expect("every pose is at rest"), test);
    let map = rms_mm(&linear(train, test), test);
    println!("fitted poses {before:.2?} mm, later ones {held_out:.2?} mm, linear map {map:.2?} mm");
    assert!(held_out[2] < 11.5 && held_out[2] < 0.65 * map[2], "{held_out:?} against {map:?}");
    assert!(held_out[1] < 5.0 && held_out[1] < map[1], "{held_out:?} against {map:?}");
    assert!(held_out[0] < 3.1, "{held_out:?}");
    let loaded = poses("100g_excerpt");
    let with = rms_mm(&trunk.predict(&loaded, 0.1).expect("every pose is at rest"), &loaded);
    let without = rms_mm(&trunk.predict(&loaded, 0.0).expect("every pose is at rest"), &loaded);
    let map = rms_mm(&linear(train, &loaded), &loaded);
    println!(
        "100 g: as a tip load {with:.2?} mm, ignored {without:.2?} mm, linear map {map:.2?} mm"
    );
    assert!(
        with[2] < 15.0 && with[2] < 0.9 * without[2] && with[2] < 0.75 * map[2],
        "{with:?} {without:?} {map:?}"
    );
}

/// The shipped numbers are where a fit to the first part ends.
#[test]
fn the_shipped_numbers_are_the_fitted_ones() {
    let all = poses("0g_excerpt");
    let train = &all[..FITTED];
    let trunk = Trunk::shipped();
    let residuals = |by: &[f64]| {
        let predicted = trunk.moved(by).predict(train, 0.0)?;
        let errors = predicted
            .iter()
            .zip(train)
            .flat_map(|(disks, pose)| (0..3).map(move |d| disks[d] - pose.disks_m[d]));
        Some(errors.flat_map(|e| [e.x, e.y, e.z]).collect::<Vec<f64>>())
    };
    let start = residuals(&[0.0; 16]).expect("every pose is at rest");
    let found = fit(&residuals, &crate::support::rods::differences(&residuals, 1e-3), &[0.0; 16])
        .expect("a fit");
    let rms = (start.iter().map(|r| r * r).sum::<f64>() / start.len() as f64).sqrt();
    println!(
        "{:.4} mm, {:.4} mm after another fit: {:.4?}",
        rms * 1e3,
        found.rms * 1e3,
        found.parameters
    );
    assert!(rms < 1.005 * found.rms, "{rms} against {}", found.rms);
    assert!(found.parameters.iter().all(|by| by.abs() < 0.02), "{:?}", found.parameters);
}
