//! Contact with obstacles against a boundary-value solver with complementarity (`tests/reference/stability`).

use crate::support::rods::{read, round_rod};
use nalgebra::Vector3;
use spinebench::rod::{Contact, LineLoad, Obstacle, ObstacleShape, Rod, RodParams, SolveStatus, TipWrench};

const LENGTH_M: f64 = 0.3;
/// Accepted distance of a tip, in lengths: a rigid obstacle gives way by 10⁻⁵ lengths, and the points of contact are 3 mm
/// apart.
const TIP_TOLERANCE: f64 = 1e-3;
/// Accepted error of the contact force, as a share.
const FORCE_TOLERANCE: f64 = 5e-3;

fn wire_against(shape: ObstacleShape) -> RodParams {
    let area_m2 = std::f64::consts::PI * 4e-6;
    let obstacle = Obstacle { shape, friction_coefficient: 0.0, stiffness_n_m: None };
    RodParams {
        damping_time_s: 0.03,
        contact: Contact { obstacles: vec![obstacle], ..Contact::default() },
        ..round_rod(LENGTH_M, 2e-3, 2.5e9, 2.5e9 / 2.78, 1200.0 * area_m2)
    }
}

fn pushed(params: &RodParams, force_x_n: f64) -> Rod {
    let mut rod = Rod::new(params.clone());
    rod.set_tip_load(TipWrench { force_n: Vector3::new(force_x_n, 0.0, 0.0), moment_nm: Vector3::zeros() });
    rod
}

fn compare(what: &str, rod: &Rod, (x_m, z_m, force_n): (f64, f64, f64)) {
    let off_m = (rod.tip_m() - Vector3::new(x_m, 0.0, z_m)).norm();
    let touching = rod.contact();
    println!("{what}: {off_m:.2e} m, {:?} N of {force_n}, {:?}, {:?} refinements {}", touching.map(|c| c.force_n.norm()), touching.map(|c| c.s_m), rod.effort(), rod.refinements());
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
        let status = rod.settle(&[]); println!("{status} {:?} {}", rod.effort(), rod.space_error_m()); assert_eq!(status, SolveStatus::Converged, "{what}");
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
        let status = rod.settle(&[]); println!("{status} {:?} {}", rod.effort(), rod.space_error_m()); assert_eq!(status, SolveStatus::Converged, "{what}");
        compare(&what, &rod, (row["tip_x_m"], row["tip_z_m"], row["contact_force_n"]));
        if let Some(contact) = rod.contact() {
            assert!((contact.s_m - row["contact_s_m"]).abs() < 2e-3, "{what}: {} m", contact.s_m);
        }
    }
}
