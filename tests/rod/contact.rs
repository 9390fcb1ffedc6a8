//! Contact with obstacles against a boundary-value solver with complementarity
//! (`tests/reference/stability`).

use std::collections::HashMap;

use crate::support::rods::{model, read, round_rod, vector};
use nalgebra::Vector3;
use spinebench::rod::{
    ContactSurface, Drive, LineLoad, Obstacle, ObstacleShape, Rod, RodParams, SolveStatus,
    TipWrench,
};

const LENGTH_M: f64 = 0.3;
/// Accepted distance of a tip, in lengths: a rigid obstacle gives way by 10⁻⁵ lengths, and the
/// points of contact are 1.6 mm apart.
const TIP_TOLERANCE: f64 = 1e-3;
/// Accepted error of the contact force, as a share.
const FORCE_TOLERANCE: f64 = 5e-3;

fn wire_against(shape: ObstacleShape) -> RodParams {
    let area_m2 = std::f64::consts::PI * 4e-6;
    let obstacle = Obstacle { shape, friction_coefficient: 0.0, stiffness_n_m: None };
    RodParams {
        damping_time_s: 0.03,
        contact: ContactSurface { obstacles: vec![obstacle], ..ContactSurface::default() },
        ..round_rod(LENGTH_M, 2e-3, 2.5e9, 2.5e9 / 2.78, 1200.0 * area_m2)
    }
}

fn pushed(params: &RodParams, force_x_n: f64) -> Rod {
    let mut rod = Rod::new(params.clone());
    rod.set_tip_load(TipWrench {
        force_n: Vector3::new(force_x_n, 0.0, 0.0),
        moment_nm: Vector3::zeros(),
    });
    rod
}

fn compare(what: &str, rod: &Rod, (x_m, z_m, force_n): (f64, f64, f64)) {
    let off_m = (rod.tip_m() - Vector3::new(x_m, 0.0, z_m)).norm();
    let touching = rod.contact();
    println!("{what}: {off_m:.2e} m, {touching:?}, expected {force_n} N");
    assert!(off_m < TIP_TOLERANCE * LENGTH_M, "{what}: {off_m} m");
    let force_off = (touching.map_or(0.0, |contact| contact.force_n.norm()) - force_n).abs();
    assert!(force_off <= FORCE_TOLERANCE * force_n, "{what}: {force_off} N");
}

#[test]
fn a_rod_pressed_on_a_plane_lies_where_the_complementarity_problem_says() {
    let plane = ObstacleShape::HalfSpace { normal: Vector3::x(), offset_m: -0.03 };
    for row in read("tests/reference/stability/contact_plane.csv") {
        let mut params = wire_against(plane.clone());
        let force_n_m = Vector3::new(row["line_force_x_n_m"], 0.0, 0.0);
        params.line_loads = vec![LineLoad { start_m: 0.0, end_m: LENGTH_M, force_n_m }];
        let mut rod = pushed(&params, row["tip_force_x_n"]);
        let what = format!("{} N, {} N/m", row["tip_force_x_n"], row["line_force_x_n_m"]);
        assert_eq!(rod.settle(&[]), SolveStatus::Converged, "{what}");
        compare(&what, &rod, (row["tip_x_m"], row["tip_z_m"], row["contact_force_n"]));
    }
}

#[test]
fn a_rod_bent_over_a_cylinder_touches_where_the_complementarity_problem_says() {
    let cylinder = ObstacleShape::Cylinder {
        center_m: Vector3::new(-0.035, 0.0, 0.15),
        axis: Vector3::y(),
        radius_m: 0.02,
        length_m: f64::INFINITY,
    };
    for row in read("tests/reference/stability/contact_cylinder.csv") {
        let mut rod = pushed(&wire_against(cylinder.clone()), row["tip_force_x_n"]);
        let what = format!("{} N", row["tip_force_x_n"]);
        assert_eq!(rod.settle(&[]), SolveStatus::Converged, "{what}");
        compare(&what, &rod, (row["tip_x_m"], row["tip_z_m"], row["contact_force_n"]));
        if let Some(contact) = rod.contact() {
            assert!((contact.s_m - row["contact_s_m"]).abs() < 2e-3, "{what}: {} m", contact.s_m);
        }
    }
}

/// A cantilever whose tip is pressed on a plane and pushed along it.
fn rubbing(friction_coefficient: f64) -> Rod {
    let plane = ObstacleShape::HalfSpace { normal: Vector3::x(), offset_m: -0.03 };
    let mut params = wire_against(plane);
    params.contact.obstacles[0].friction_coefficient = friction_coefficient;
    let mut rod = pushed(&params, -0.6);
    assert_eq!(rod.settle(&[]), SolveStatus::Converged);
    rod
}

#[test]
fn friction_holds_a_tip_up_to_the_coulomb_limit() {
    let side_n = |rod: &mut Rod, side_n: f64| {
        rod.set_tip_load(TipWrench {
            force_n: Vector3::new(-0.6, side_n, 0.0),
            moment_nm: Vector3::zeros(),
        });
        assert_eq!(rod.settle(&[]), SolveStatus::Converged);
        (rod.tip_m().y, rod.contact().unwrap().force_n)
    };
    let (free_m, _) = side_n(&mut rubbing(0.0), 0.1);
    assert!(free_m > 0.02, "{free_m}");
    let mut rod = rubbing(0.5);
    // The limit is half of 0.49 N: 0.1 N is held.
    let (held_m, force_n) = side_n(&mut rod, 0.1);
    assert!(held_m.abs() < 1e-3 * free_m && (force_n.y + 0.1).abs() < 2e-3, "{held_m} {force_n}");
    // 0.4 N is not: it slips, with the limit against it.
    let (slipped_m, force_n) = side_n(&mut rod, 0.4);
    let limit = force_n.y.hypot(force_n.z) / force_n.x;
    assert!(slipped_m > free_m && (limit - 0.5).abs() < 5e-3, "{slipped_m} {force_n}");
    // Without the force friction holds it where it is: the rod pulls back with 0.15 N.
    let (back_m, force_n) = side_n(&mut rod, 0.0);
    assert!(
        back_m > 0.95 * slipped_m && back_m < slipped_m && force_n.y > 0.1,
        "{back_m} {force_n}"
    );
}

#[test]
fn a_motion_against_a_sphere_is_that_of_another_engine() {
    let mut model = model("nominal");
    model.robot.tendons.compliance_m_per_n = spinebench::effects::PerTendon::Same(7e-5);
    let rows = read("tests/reference/stability/sphere_motion.csv");
    let play = |radius_m: Option<f64>| {
        let mut params = model.rod(&[]);
        let center_m = Vector3::new(0.028, 0.006, 0.140);
        params.contact.obstacles.extend(radius_m.map(|radius_m| Obstacle {
            shape: ObstacleShape::Sphere { center_m, radius_m },
            friction_coefficient: 0.0,
            stiffness_n_m: None,
        }));
        let mut rod = Rod::new(params);
        let pulls = |row: &HashMap<String, f64>| {
            (1..=4).map(|i| row[&format!("tendon_{i}_m")]).collect::<Vec<_>>()
        };
        let (mut now, mut squares, mut touching, mut force_off) = (vec![0.0; 4], 0.0, 0, 0.0_f64);
        let all =
            |pulls_m: &[f64]| pulls_m.iter().map(|&pull_m| Drive::Pull(pull_m)).collect::<Vec<_>>();
        assert_eq!(rod.settle(&all(&now)), SolveStatus::Converged);
        for row in &rows {
            let measured_m = vector(row, ["tip_x_m", "tip_y_m", "tip_z_m"]);
            squares += (rod.tip_m() - measured_m).norm_squared();
            let force_n = rod.contact().map_or(Vector3::zeros(), |contact| contact.force_n);
            touching += usize::from((force_n.norm() > 0.0) == (row["contact"] > 0.0));
            force_off = force_off
                .max((force_n - vector(row, ["force_x_n", "force_y_n", "force_z_n"])).norm());
            let (from, to) = (now.clone(), pulls(row));
            let drives = |t: f64| {
                let share = (t / 0.02).min(1.0);
                all(&from.iter().zip(&to).map(|(a, b)| a + share * (b - a)).collect::<Vec<_>>())
            };
            assert_eq!(rod.advance_with(&drives, 0.02), SolveStatus::Converged);
            assert_eq!(rod.advance(&all(&to), 0.18), SolveStatus::Converged);
            now = to;
        }
        ((squares / rows.len() as f64).sqrt(), touching, force_off)
    };
    let (free_m, ..) = play(None);
    let (off_m, touching, force_off_n) = play(Some(0.020));
    println!(
        "without {free_m:.5} m, with {off_m:.5} m, contact alike in {touching} of {}, \
         {force_off_n} N",
        rows.len()
    );
    assert!(free_m > 8e-3 && off_m < 4e-4, "{free_m} and {off_m}");
    assert!(touching == rows.len() && force_off_n < 0.04, "{touching}, {force_off_n} N");
}

#[test]
fn an_obstacle_in_the_robot_at_home_is_told() {
    let at = |offset_m: f64| {
        let mut params = wire_against(ObstacleShape::HalfSpace { normal: Vector3::x(), offset_m });
        params.contact.radius_m = 0.002;
        Rod::touched_at_home(&params)
    };
    assert_eq!(at(-0.0021), None);
    let home = at(-0.001).unwrap();
    assert!(home.obstacle == 0 && (home.penetration_m - 0.001).abs() < 1e-12, "{home:?}");
}

#[test]
fn a_coil_that_closes_touches_itself() {
    let curled = |curvature_rad_m: f64| {
        let mut params =
            wire_against(ObstacleShape::HalfSpace { normal: Vector3::x(), offset_m: -9.0 });
        params.contact.radius_m = 0.002;
        params.spans[0].rest_curvature_rad_m = Vector3::new(0.0, curvature_rad_m, 0.0);
        let mut rod = Rod::new(params);
        assert_eq!(rod.settle(&[]), SolveStatus::Converged);
        rod.self_contact()
    };
    assert_eq!(curled(10.0), None);
    assert_eq!(curled(18.0), None);
    let contact = curled(1.05 * std::f64::consts::TAU / LENGTH_M).unwrap();
    assert!(contact.s_m[0] < 0.03 && contact.s_m[1] > 0.27, "{contact:?}");
}
