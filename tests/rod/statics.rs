//! The rod against reference solutions of other codes and against closed forms, at rest.

use crate::support::rods::{four_tendons, reference, rotation, round_rod, shipped, vector};
use nalgebra::Vector3;
use rand::RngExt;
use spinebench::base::Seed;
use spinebench::rod::{Drive, Rod, SolveStatus, TipWrench};

/// Position in metres and rotation (Frobenius norm) that a static solution may be off by.
const POSITION_M: f64 = 1e-6;
const ROTATION: f64 = 1e-5;

#[test]
fn tension_control_matches_till() {
    for row in reference("till_statics_tension.csv") {
        let mut params = shipped("till");
        params.gravity_m_s2 = vector(&row, ["gx", "gy", "gz"]);
        let mut rod = Rod::new(params);
        rod.set_tip_load(TipWrench {
            force_n: vector(&row, ["fx", "fy", "fz"]),
            moment_nm: vector(&row, ["lx", "ly", "lz"]),
        });
        let drives: Vec<Drive> = (1..=4).map(|i| Drive::Tension(row[&format!("tau{i}")])).collect();
        assert_eq!(rod.settle(&drives), SolveStatus::Converged, "case {}", row["id"]);
        let position = (rod.tip_m() - vector(&row, ["px", "py", "pz"])).norm();
        let turn = (rod.tip_rotation() - rotation(&row, "")).norm();
        println!("case {}: {:.2e} m {:.2e}", row["id"], position, turn);
        assert!(
            position < POSITION_M && turn < ROTATION,
            "case {}: {position:e} m, {turn:e}",
            row["id"]
        );
    }
}

#[test]
fn length_control_matches_the_independent_solver_from_a_cold_start() {
    for row in reference("statics_length_control.csv") {
        let mut params = match row["robot"] as i64 {
            0 => shipped("till"),
            robot => {
                let mut params =
                    round_rod(0.22, 2e-3, 2.33e9, 2.33e9 / (2.0 * 1.3897), 0.05 / 0.22);
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
        rod.set_tip_load(TipWrench {
            force_n: vector(&row, ["fx", "fy", "fz"]),
            moment_nm: Vector3::zeros(),
        });
        let drives: Vec<Drive> = (1..=4).map(|i| Drive::Pull(row[&format!("q{i}")])).collect();
        let status = rod.settle(&drives);
        let position = (rod.tip_m() - vector(&row, ["px", "py", "pz"])).norm();
        let turn = (rod.tip_rotation() - rotation(&row, "")).norm();
        println!(
            "case {} robot {}: {status} {:.2e} m {:.2e} {:?}",
            row["id"],
            row["robot"],
            position,
            turn,
            rod.effort()
        );
        assert_eq!(status, SolveStatus::Converged, "case {}", row["id"]);
        assert!(
            position < POSITION_M && turn < ROTATION,
            "case {}: {position:e} m, {turn:e}",
            row["id"]
        );
        for (i, tension) in rod.tensions_n().iter().enumerate() {
            let expected = row[&format!("tau{}", i + 1)];
            assert!(
                (tension - expected).abs() < 1e-4 * (1.0 + expected),
                "case {} tendon {i}",
                row["id"]
            );
        }
    }
}

#[test]
fn two_segments_match_the_consistent_border_rule() {
    for row in reference("tdcr_two_segment_statics.csv") {
        let params = shipped("tdcr_two_segments");
        let mut rod = Rod::new(params);
        rod.set_tip_load(TipWrench {
            force_n: vector(&row, ["fx", "fy", "fz"]),
            moment_nm: vector(&row, ["lx", "ly", "lz"]),
        });
        let drives: Vec<Drive> = (1..=6).map(|i| Drive::Tension(row[&format!("tau{i}")])).collect();
        let status = rod.settle(&drives);
        let position = (rod.tip_m() - vector(&row, ["ref_px", "ref_py", "ref_pz"])).norm();
        let turn = (rod.tip_rotation() - rotation(&row, "ref_")).norm();
        println!("case {}: {status} {position:.2e} m {turn:.2e} {:?}", row["id"], rod.effort());
        assert_eq!(status, SolveStatus::Converged, "case {}", row["id"]);
        assert!(
            position < POSITION_M && turn < ROTATION,
            "case {}: {position:e} m, {turn:e}",
            row["id"]
        );
    }
}

#[test]
fn heavy_cantilever_deflects_as_beam_theory_says() {
    // Small deflection of a stiff rod under its weight: w L⁴ / (8 E I) plus shear w L² / (2 G A).
    let (length, radius, e, g) = (0.3, 2e-3, 70e9, 26e9);
    let area = std::f64::consts::PI * radius * radius;
    let mut params = round_rod(length, radius, e, g, 2700.0 * area);
    params.gravity_m_s2 = Vector3::new(-9.81, 0.0, 0.0);
    let bending = params.spans[0].bending_n_m2[0];
    let mut rod = Rod::new(params);
    assert_eq!(rod.settle(&[]), SolveStatus::Converged);
    let weight_n_m = 2700.0 * area * 9.81;
    let expected = weight_n_m * length.powi(4) / (8.0 * bending)
        + weight_n_m * length.powi(2) / (2.0 * g * area);
    assert!(
        (rod.tip_m().x + expected).abs() < 1e-6 * length,
        "{} against {expected}",
        rod.tip_m().x
    );
}

#[test]
fn a_tip_moment_bends_the_rod_into_an_exact_arc() {
    let mut params = round_rod(0.22, 2e-3, 2.33e9, 0.84e9, 0.05);
    params.spans[0].axial_n = 1e12;
    let moment = 2.0 * params.spans[0].bending_n_m2[0] / 0.22;
    let mut rod = Rod::new(params);
    rod.set_tip_load(TipWrench {
        force_n: Vector3::zeros(),
        moment_nm: Vector3::new(0.0, moment, 0.0),
    });
    assert_eq!(rod.settle(&[]), SolveStatus::Converged);
    let arc_radius = 0.22 / 2.0;
    let expected =
        Vector3::new(arc_radius * (1.0 - 2.0_f64.cos()), 0.0, arc_radius * 2.0_f64.sin());
    let off = (rod.tip_m() - expected).norm();
    assert!(off < 2e-8, "{off:e} m from the arc");
}

#[test]
fn answers_do_not_depend_on_where_the_rod_came_from() {
    // Lengths, followers and tensions in turn, slack and taut, with a tip load that comes and goes:
    // from each equilibrium to the next the rod reuses what it knows, and must end where a straight
    // rod does.
    let mut rod = Rod::new(shipped("nominal"));
    let mut random = Seed(7).rng();
    for k in 0..120 {
        let reach_m = if k % 3 == 0 { 0.015 } else { 0.002 };
        let drives: [Drive; 4] = std::array::from_fn(|_| {
            let pull_m: f64 = random.random_range(-reach_m..reach_m);
            match random.random_range(0..4) {
                0 if k % 5 == 0 => Drive::Follow,
                1 if k % 5 == 0 => Drive::Tension(200.0 * pull_m.abs()),
                _ => Drive::Pull(pull_m),
            }
        });
        let force_n = Vector3::new(if k % 7 == 0 { -0.3 } else { 0.0 }, 0.0, 0.0);
        let load = TipWrench { force_n, moment_nm: Vector3::zeros() };
        let mut fresh = Rod::new(shipped("nominal"));
        rod.set_tip_load(load);
        fresh.set_tip_load(load);
        let (status, expected) = (rod.settle(&drives), fresh.settle(&drives));
        assert_eq!(status, expected, "{k}: {drives:?}");
        let off_m = (rod.tip_m() - fresh.tip_m()).norm();
        assert!(off_m < 1e-7, "{k}: {off_m:e} m for {drives:?}");
        for (warm, cold) in rod.tensions_n().iter().zip(fresh.tensions_n()) {
            assert!((warm - cold).abs() < 1e-3, "{k}: {warm} N, {cold} N");
        }
    }
}
