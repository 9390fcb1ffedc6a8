//! Loss of stability against values of other methods (`tests/reference/stability`), at rest and in
//! motion.

use crate::support::rods::{read, round_rod};
use nalgebra::Vector3;
use rayon::prelude::*;
use spinebench::base::Seed;
use spinebench::rod::{PointLoad, RestBranch, Rod, RodParams, SolveStatus, TipWrench};

/// Euler's load of [`wire_of_30_cm`], N.
const EULER_N: f64 = 0.861_285_463_341_661_9;
const LENGTH_M: f64 = 0.3;
/// Accepted distance of a tip, in lengths.
const TIP_TOLERANCE: f64 = 2e-5;

/// A straight rod without weight of 30 cm, E·I = 0.0314 N m².
fn wire_of_30_cm() -> RodParams {
    let area_m2 = std::f64::consts::PI * 4e-6;
    let shear_pa = 2.5e9 / (2.0 * 1.39);
    RodParams {
        damping_time_s: 0.03,
        ..round_rod(LENGTH_M, 2e-3, 2.5e9, shear_pa, 1200.0 * area_m2)
    }
}

/// A stiff thin wire of 18 cm.
fn thin_wire() -> RodParams {
    let area_m2 = std::f64::consts::PI * 0.25e-6;
    RodParams { damping_time_s: 0.03, ..round_rod(0.18, 5e-4, 70e9, 70e9 / 2.66, 6450.0 * area_m2) }
}

fn push(x_n: f64, z_n: f64) -> TipWrench {
    TipWrench { force_n: Vector3::new(x_n, 0.0, z_n), moment_nm: Vector3::zeros() }
}

/// Distance of the tip from a place in the plane of x and z, metres.
fn distance_m(rod: &Rod, x_m: f64, z_m: f64) -> f64 {
    (rod.tip_m() - Vector3::new(x_m, 0.0, z_m)).norm()
}

#[test]
fn a_buckled_rod_rests_where_the_elastica_does() {
    for (row, thin) in read("tests/reference/stability/elastica.csv")
        .into_iter()
        .zip(names_of_column("elastica.csv", 0))
    {
        let params = if thin == "wire" { thin_wire() } else { wire_of_30_cm() };
        let length_m = params.length_m();
        let mut rod = Rod::new(params);
        rod.set_tip_load(push(row["force_x_n"], row["force_z_n"]));
        assert_eq!(rod.settle(&[]), SolveStatus::Converged, "{row:?}");
        let off_m = distance_m(&rod, row["tip_x_m"], row["tip_z_m"]);
        println!(
            "{thin} {} {}: {off_m:.1e} m, {}",
            row["axial_share"],
            row["lateral_share"],
            rod.branch().name()
        );
        assert!(off_m < TIP_TOLERANCE * length_m, "{row:?}: {off_m} m");
    }
}

#[test]
fn of_two_sides_that_are_alike_a_rod_takes_that_of_x() {
    let mut rod = Rod::new(wire_of_30_cm());
    for axial_share in [1.05, 1.5, 2.0, 3.0] {
        rod.restart();
        rod.set_tip_load(push(0.0, -axial_share * EULER_N));
        assert_eq!(rod.settle(&[]), SolveStatus::Converged, "{axial_share}");
        assert_eq!(rod.branch(), RestBranch::Bifurcation);
        let tip_m = rod.tip_m();
        assert!(tip_m.x > 0.05 && tip_m.y.abs() < 1e-6, "{axial_share}: {tip_m}");
    }
    // Unloaded again it is straight, and below the load it stays so.
    for axial_share in [0.0, 0.99] {
        rod.set_tip_load(push(0.0, -axial_share * EULER_N));
        assert_eq!(rod.settle(&[]), SolveStatus::Converged);
        assert!(rod.tip_m().x.abs() < 1e-9, "{axial_share}: {}", rod.tip_m());
    }
}

#[test]
fn a_motion_past_the_buckling_load_does_not_rest_on_the_unstable_branch() {
    for row_s in [0.05, 0.1, 0.2, 0.5] {
        for lateral in [1e-3, 1e-6, 0.0] {
            let mut rod = Rod::new(wire_of_30_cm());
            rod.set_tip_load(push(lateral * EULER_N, 0.0));
            assert_eq!(rod.settle(&[]), SolveStatus::Converged);
            // Its derivative, which knows nothing of the load, would do for a load along the rod.
            assert_eq!(rod.advance(&[], row_s), SolveStatus::Converged);
            rod.set_tip_load(push(lateral * EULER_N, -1.5 * EULER_N));
            for _ in 0..(6.0 / row_s) as usize {
                assert_eq!(rod.advance(&[], row_s), SolveStatus::Converged);
            }
            println!("{row_s} s, {lateral}: {:?} {:?}", rod.tip_m().as_slice(), rod.effort());
            assert!(
                distance_m(&rod, 0.236_59, 0.109_0) < 2e-4,
                "{row_s} s, {lateral}: {}",
                rod.tip_m()
            );
        }
    }
}

#[test]
fn an_upright_column_falls_at_greenhills_weight() {
    let critical = read("tests/reference/stability/greenhill.csv")[1]["load"];
    for (share, stands) in [(0.999, true), (1.001, false)] {
        let mut params = wire_of_30_cm();
        params.gravity_m_s2 = Vector3::new(0.0, 0.0, -share * critical);
        let mut rod = Rod::new(params);
        assert_eq!(rod.settle(&[]), SolveStatus::Converged, "{share}");
        let branch = if stands { RestBranch::Same } else { RestBranch::Bifurcation };
        println!("{share}: {:?}", rod.tip_m().as_slice());
        assert_eq!(
            (rod.branch(), rod.tip_m().x > 1e-3),
            (branch, !stands),
            "{share}: {}",
            rod.tip_m()
        );
    }
}

/// Beck's column under a share of its reference load.
fn beck(load_n: f64, damping_time_s: f64) -> RodParams {
    let mut params = RodParams { damping_time_s, ..wire_of_30_cm() };
    let force_n = Vector3::new(0.0, 0.0, -load_n);
    params.point_loads = vec![PointLoad {
        position_m: LENGTH_M,
        force_n,
        moment_nm: Vector3::zeros(),
        follows: true,
    }];
    params
}

#[test]
fn a_follower_load_makes_a_column_flutter_at_becks_load() {
    let rows = read("tests/reference/stability/beck.csv");
    for row in rows.iter().filter(|row| row["share_of_undamped"].is_nan()) {
        // The reference has neither shear, which lowers the load by P/GA, nor damping of shear,
        // which raises it.
        let load_n = row["load_n"] * (1.0 - row["load_n"] / 11302.0);
        let tolerance = if row["damping_time_s"] > 0.01 { 0.02 } else { 0.001 };
        let status = |share: f64| Rod::new(beck(share * load_n, row["damping_time_s"])).settle(&[]);
        println!("{} s: {load_n} N", row["damping_time_s"]);
        assert_eq!(status(1.0 - tolerance), SolveStatus::Converged, "{row:?}");
        assert_eq!(status(1.0 + tolerance), SolveStatus::Flutters, "{row:?}");
    }
}

#[test]
fn a_motion_that_starts_from_a_fluttering_rest_grows_as_the_eigenvalue_says() {
    let rows = read("tests/reference/stability/beck.csv");
    let growing = |row: &&std::collections::HashMap<String, f64>| {
        row["lambda_real_1_per_s"] > 1.0 && row["damping_time_s"] == 0.0
    };
    for row in rows.iter().filter(growing) {
        let mut rod = Rod::new(beck(row["load_n"], 0.0));
        assert_eq!(rod.settle(&[]), SolveStatus::Flutters);
        // Largest deviation in each of two periods that lie apart.
        let period_s = std::f64::consts::TAU / row["lambda_imag_1_per_s"];
        let mut largest = |periods: f64| {
            let mut largest_m = 0.0_f64;
            for _ in 0..40 {
                assert_eq!(rod.advance(&[], periods * period_s / 40.0), SolveStatus::Converged);
                largest_m = largest_m.max(rod.tip_m().x.abs());
            }
            largest_m
        };
        largest(3.0 / (row["lambda_real_1_per_s"] * period_s));
        let (first_m, second_m) = (largest(1.0), largest(1.0));
        let rate = (second_m / first_m).ln() / period_s;
        println!("{} N: {rate} 1/s, expected {}", row["load_n"], row["lambda_real_1_per_s"]);
        assert!((rate / row["lambda_real_1_per_s"] - 1.0).abs() < 0.05, "{row:?}: {rate}");
    }
}

#[test]
fn a_curved_strip_snaps_through_at_its_fold() {
    let rows = read("tests/reference/stability/snap.csv");
    let kinds = names_of_column("snap.csv", 2);
    for curvature in [1.0, 0.5, 0.3] {
        let own: Vec<_> = rows
            .iter()
            .zip(&kinds)
            .filter(|(row, _)| row["rest_curvature_rad_m"] == curvature)
            .collect();
        let fold = own.iter().filter(|(_, kind)| *kind == "fold").map(|(row, _)| row["force_x_n"]);
        let fold_n = fold.reduce(f64::min).unwrap();
        let mut params = wire_of_30_cm();
        params.spans[0].rest_curvature_rad_m = Vector3::new(0.0, curvature, 0.0);
        // Twice as stiff out of the plane, where a round rod would swing aside before.
        params.spans[0].bending_n_m2[0] *= 2.0;
        let mut rod = Rod::new(params);
        let mut settle = |row: &std::collections::HashMap<String, f64>, x_n: f64| {
            rod.set_tip_load(push(x_n, row["force_z_n"]));
            assert_eq!(rod.settle(&[]), SolveStatus::Converged, "{curvature}, {x_n} N");
            (rod.tip_m(), rod.branch())
        };
        let mut upper: Vec<_> =
            own.iter().filter(|(_, kind)| *kind == "upper").map(|(row, _)| *row).collect();
        upper.sort_by(|a, b| b["force_x_n"].total_cmp(&a["force_x_n"]));
        for row in &upper {
            let (tip_m, branch) = settle(row, row["force_x_n"]);
            let off_m = (tip_m - Vector3::new(row["tip_x_m"], 0.0, row["tip_z_m"])).norm();
            println!("{curvature}: {} N: {off_m:.1e} m {}", row["force_x_n"], branch.name());
            assert!(
                off_m < TIP_TOLERANCE * LENGTH_M && branch == RestBranch::Same,
                "{row:?}: {off_m} m {branch:?}"
            );
        }
        let (tip_m, branch) = settle(upper[0], fold_n + 1e-3 * EULER_N);
        assert!(tip_m.x > 0.0 && branch == RestBranch::Same, "{curvature}: {tip_m} {branch:?}");
        let (tip_m, branch) = settle(upper[0], fold_n - 1e-3 * EULER_N);
        assert!(
            tip_m.x < 0.0 && branch == RestBranch::SnapThrough,
            "{curvature}: {tip_m} {branch:?}"
        );
        let lower = own.iter().filter(|(row, kind)| *kind == "lower" && row["force_x_n"] < fold_n);
        for (row, _) in lower {
            let (tip_m, _) = settle(row, row["force_x_n"]);
            let off_m = (tip_m - Vector3::new(row["tip_x_m"], 0.0, row["tip_z_m"])).norm();
            assert!(off_m < TIP_TOLERANCE * LENGTH_M, "{row:?}: {off_m} m");
        }
    }
}

/// One column of a reference file as text.
fn names_of_column(file: &str, column: usize) -> Vec<String> {
    let path = format!("{}/tests/reference/stability/{file}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    text.lines()
        .skip(1)
        .map(|line| line.split(',').nth(column).unwrap_or_default().to_owned())
        .collect()
}

/// A random wire, and a random share of its buckling load with a little beside it.
fn random_column(random: &mut impl rand::RngExt) -> (RodParams, TipWrench) {
    let mut log =
        |low: f64, high: f64| (low.ln() + random.random_range(0.0..1.0) * (high / low).ln()).exp();
    let (length_m, slenderness, e_pa) = (log(0.05, 1.0), log(0.002, 0.03), log(1e6, 2e11));
    let radius_m = slenderness * length_m;
    let area_m2 = std::f64::consts::PI * radius_m * radius_m;
    let mut params = round_rod(length_m, radius_m, e_pa, e_pa / 2.7, 2000.0 * area_m2);
    let softer = random.random_range(0.3..1.0);
    params.spans[0].bending_n_m2[1] *= softer;
    params.spans[0].principal_angle_rad = random.random_range(-1.5..1.5);
    if random.random_range(0..2) == 1 {
        let [about_x, about_y] = [(); 2].map(|()| random.random_range(-0.15..0.15) / length_m);
        params.spans[0].rest_curvature_rad_m = Vector3::new(about_x, about_y, 0.0);
    }
    let stiffness_n_m2 = params.spans[0].bending_n_m2[1];
    // The first mode of the unloaded wire decays within a few periods.
    params.damping_time_s =
        0.1 * length_m * length_m * (params.spans[0].mass_kg_m / stiffness_n_m2).sqrt();
    let euler_n = std::f64::consts::PI.powi(2) * stiffness_n_m2 / (4.0 * length_m * length_m);
    let (angle, lateral) =
        (random.random_range(0.0..std::f64::consts::TAU), random.random_range(0.0..1.0_f64));
    let side = Vector3::new(f64::cos(angle), f64::sin(angle), 0.0) * 1e-2 * lateral.powi(4);
    let force_n = (side - Vector3::z() * random.random_range(0.5..3.0)) * euler_n;
    (params, TipWrench { force_n, moment_nm: Vector3::zeros() })
}

/// Settles random columns and disturbs what has converged: the share that converged. None may be
/// left by the rod.
fn share_of_stable_rests(draws: u64) -> f64 {
    let one = |number: u64| {
        let (params, load) = random_column(&mut Seed(52).index(number).rng());
        let (length_m, time_s) = (params.length_m(), 10.0 * params.damping_time_s);
        let mut rod = Rod::new(params);
        rod.set_tip_load(load);
        let status = rod.settle(&[]);
        if status != SolveStatus::Converged {
            println!("draw {number}: {status}");
            return false;
        }
        let rest_m = rod.tip_m();
        let shoved = load.force_n + rod.tip_rotation().column(0) * (3e-3 * load.force_n.norm());
        for (force_n, periods) in [(shoved, 3.0), (load.force_n, 30.0)] {
            rod.set_tip_load(TipWrench { force_n, ..load });
            assert_eq!(
                rod.advance(&[], periods * time_s),
                SolveStatus::Converged,
                "draw {number} moves"
            );
        }
        let away = (rod.tip_m() - rest_m).norm() / length_m;
        assert!(away < 0.1, "draw {number} has left its rest by {away} lengths");
        true
    };
    (0..draws).into_par_iter().filter(|&number| one(number)).count() as f64 / draws as f64
}

#[test]
fn random_columns_rest_where_they_stay() {
    let share = share_of_stable_rests(200);
    println!("converged: {share}");
    assert!(share > 0.99, "{share}");
}

#[test]
#[ignore = "make campaign"]
fn ten_thousand_random_columns_rest_where_they_stay() {
    let share = share_of_stable_rests(10_000);
    println!("converged: {share}");
    assert!(share > 0.99, "{share}");
}
