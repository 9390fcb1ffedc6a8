//! The rod against reference solutions of other codes and against closed forms, at rest.

mod common;

use common::{four_tendons, reference, rotation, round_rod, till_robot, vector};
use nalgebra::Vector3;
use spinebench::rod::{Drive, Rod, Status, TipLoad};

/// Position in metres and rotation (Frobenius norm) that a static solution may be off by.
const POSITION_M: f64 = 1e-6;
const ROTATION: f64 = 1e-5;

#[test]
fn tension_control_matches_till() {
    for row in reference("till_statics_tension.csv") {
        let mut params = till_robot();
        params.gravity_m_s2 = vector(&row, ["gx", "gy", "gz"]);
        let mut rod = Rod::new(params);
        rod.set_tip_load(TipLoad {
            force_n: vector(&row, ["fx", "fy", "fz"]),
            moment_nm: vector(&row, ["lx", "ly", "lz"]),
        });
        let drives: Vec<Drive> = (1..=4).map(|i| Drive::Tension(row[&format!("tau{i}")])).collect();
        assert_eq!(rod.settle(&drives), Status::Converged, "case {}", row["id"]);
        let position = (rod.tip_m() - vector(&row, ["px", "py", "pz"])).norm();
        let turn = (rod.tip_rotation() - rotation(&row, "")).norm();
        println!("case {}: {:.2e} m {:.2e}", row["id"], position, turn);
        assert!(position < POSITION_M && turn < ROTATION, "case {}: {position:e} m, {turn:e}", row["id"]);
    }
}

#[test]
fn length_control_matches_the_independent_solver_from_a_cold_start() {
    for row in reference("statics_length_control.csv") {
        let mut params = match row["robot"] as i64 {
            0 => till_robot(),
            robot => {
                let mut params = round_rod(0.22, 2e-3, 2.33e9, 2.33e9 / (2.0 * 1.3897), 0.05 / 0.22);
                let compliance = if robot == 1 { 1e-4 } else { 1e-3 };
                params.tendons = four_tendons(0.02, 0.22, compliance * 0.22);
                params.gravity_m_s2 = Vector3::new(-9.81, 0.0, 0.0);
                if robot == 2 {
                    params.spans[0].axial_n = 100.0;
                }
                params
            }
        };
        if row["robot"] == 0.0 {
            params.gravity_m_s2 = Vector3::new(9.81, 0.0, 0.0);
        }
        let mut rod = Rod::new(params);
        rod.set_tip_load(TipLoad { force_n: vector(&row, ["fx", "fy", "fz"]), moment_nm: Vector3::zeros() });
        let drives: Vec<Drive> = (1..=4).map(|i| Drive::Pull(row[&format!("q{i}")])).collect();
        let status = rod.settle(&drives);
        let position = (rod.tip_m() - vector(&row, ["px", "py", "pz"])).norm();
        let turn = (rod.tip_rotation() - rotation(&row, "")).norm();
        println!("case {} robot {}: {status} {:.2e} m {:.2e} {:?}", row["id"], row["robot"], position, turn, rod.effort());
        assert_eq!(status, Status::Converged, "case {}", row["id"]);
        assert!(position < POSITION_M && turn < ROTATION, "case {}: {position:e} m, {turn:e}", row["id"]);
        for (i, tension) in rod.tensions_n().iter().enumerate() {
            let expected = row[&format!("tau{}", i + 1)];
            assert!((tension - expected).abs() < 1e-4 * (1.0 + expected), "case {} tendon {i}", row["id"]);
        }
    }
}
