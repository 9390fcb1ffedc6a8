//! Robots that use everything at once: tapered pieces, any tendons, loads of all kinds, a base
//! anywhere.

use nalgebra::Vector3;
use spinebench::effects::Model;
use spinebench::math::rotation;
use spinebench::rod::{Drive, Rod, RodParams, SolveStatus};
use spinebench::specs::read_model;

/// Two segments of a tapered, curved, anisotropic tube with a sheathed, a helical, a kinked and a
/// short tendon.
const EVERYTHING: &str = "
robot:
  backbone:
    {length_m: 0.3, radius_m: 0.004, youngs_modulus_pa: 1.5e9, poisson_ratio: 0.35, density_kg_m3: 1200, pieces: [
      {end_m: 0.12, end_radius_m: 0.003, inner_radius_m: 0.001, anisotropy: 0.15, principal_angle_deg: 30},
      {end_m: 0.3, end_radius_m: 0.002, end_inner_radius_m: 0.0005, rest_curvature_rad_m: [0.5, -1, 2]}]}
  sections: {count: 5, length_m: 0.01, compliance_m_per_n: 0.0002, saturation_n: 20}
  disks: {count: 2, mass_kg: 0.01, positions_m: [0.12, 0.3], masses_kg: [0.02, 0.01], inertia_kg_m2: [1e-6, 1e-6, 2e-6]}
  tendons:
    {radius_m: 0.015, angles_deg: [0, 90, 180, 270, 45], profile: [{s_m: 0.3, radius_m: 0.008}],
     twists_rad_m: [0, 6, 0, 0, 0], starts_m: [0, 0, 0, 0, 0.05], ends_m: [0.3, 0.3, 0.12, 0.3, 0.25],
     paths: [[], [], [], [{s_m: 0, x_m: 0, y_m: -0.015}, {s_m: 0.12, x_m: 0.003, y_m: -0.01}, {s_m: 0.3, x_m: 0, y_m: -0.008}], []],
     pretension_m: 0.0002, compliance_m_per_n: 1e-5}
  loads:
    - point: {position_m: 0.2, force_n: [0.2, -0.1, 0.1], moment_nm: [0.002, 0.001, 0]}
    - point: {position_m: 0.3, force_n: [0.1, 0.05, 0], moment_nm: [0, 0, 0.001], frame: body}
    - line: {start_m: 0.05, end_m: 0.25, force_n_m: [0, 0.5, 0.2]}
  damping_time_s: 0.02
";

fn everything() -> Model {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("everything.yaml");
    std::fs::write(&file, EVERYTHING).unwrap();
    read_model(&file).unwrap_or_else(|error| panic!("{error}"))
}

const PULLS: [f64; 5] = [0.004, -0.002, 0.001, -0.003, 0.008];

fn settled(params: RodParams, pulls_m: &[f64]) -> Rod {
    driven(params, &pulls_m.iter().map(|&pull| Drive::Pull(pull)).collect::<Vec<Drive>>())
}

fn driven(params: RodParams, drives: &[Drive]) -> Rod {
    let mut rod = Rod::new(params);
    assert_eq!(rod.settle(drives), SolveStatus::Converged);
    rod
}

/// Wherever the base stands and however the world is turned with it, the robot is the same.
#[test]
fn a_robot_moved_and_turned_with_its_world_is_the_same_robot() {
    let params = everything().rod(&[]);
    let shift = Vector3::new(0.3, -1.2, 0.7);
    let vector = Vector3::new(1.1, -0.4, 2.0);
    let turn = rotation::exp(&vector);
    let mut moved = params.clone();
    moved.base_m = shift;
    moved.base_rotation_rad = vector;
    moved.gravity_m_s2 = turn * moved.gravity_m_s2;
    for load in moved.point_loads.iter_mut().filter(|load| !load.follows) {
        (load.force_n, load.moment_nm) = (turn * load.force_n, turn * load.moment_nm);
    }
    moved.line_loads.iter_mut().for_each(|load| load.force_n_m = turn * load.force_n_m);
    let (mut here, mut there) = (settled(params, &PULLS), settled(moved, &PULLS));
    let drives: Vec<Drive> = PULLS.iter().map(|pull| Drive::Pull(-0.5 * pull)).collect();
    for step in 0..4 {
        let off = (turn * here.tip_m() + shift - there.tip_m()).norm();
        println!("step {step}: {off:.2e} m apart, tip at {:?}", here.tip_m());
        assert!(off < 1e-7, "step {step}: {off:e} m");
        assert_eq!(here.advance(&drives, 0.05), SolveStatus::Converged);
        assert_eq!(there.advance(&drives, 0.05), SolveStatus::Converged);
    }
}

/// What moves comes to rest where statics say, and a rod at rest stays there.
#[test]
fn motion_ends_where_statics_say() {
    let params = everything().rod(&[]);
    let mut rod = settled(params.clone(), &[0.0; 5]);
    let target = settled(params, &PULLS);
    let drives: Vec<Drive> = PULLS.iter().map(|&pull| Drive::Pull(pull)).collect();
    let start = (rod.tip_m() - target.tip_m()).norm();
    assert_eq!(rod.advance(&drives, 8.0), SolveStatus::Converged);
    let off = (rod.tip_m() - target.tip_m()).norm();
    println!("{start:.3} m apart before, {off:.2e} m after");
    assert!(start > 0.01 && off < 1e-6, "{off:e} m");
}

/// Each way to bend the rules by a thousandth bends the answer by about that: nothing jumps.
#[test]
fn the_answer_changes_steadily_with_the_robot() {
    let tip = |change: &dyn Fn(&mut Model)| {
        let mut model = everything();
        change(&mut model);
        driven(model.rod(&[]), &[3.0, 2.0, 1.0, 2.5, 1.5].map(Drive::Tension)).tip_m()
    };
    let home = tip(&|_| {});
    type Change<'a> = &'a dyn Fn(&mut Model, f64);
    let changes: [(&str, Change); 7] = [
        ("end radius", &|m, x| m.robot.backbone.pieces[1].end_radius_m = Some(0.002 * (1.0 + x))),
        ("piece border", &|m, x| m.robot.backbone.pieces[0].end_m = 0.12 * (1.0 + x)),
        ("tendon end", &|m, x| m.robot.tendons.ends_m.as_mut().unwrap()[2] = 0.12 * (1.0 + x)),
        ("tendon start", &|m, x| m.robot.tendons.starts_m.as_mut().unwrap()[4] = 0.05 * (1.0 + x)),
        ("kink", &|m, x| m.robot.tendons.paths.as_mut().unwrap()[3][1].s_m = 0.12 * (1.0 + x)),
        ("twist", &|m, x| m.robot.tendons.twists_rad_m.as_mut().unwrap()[1] = 6.0 * (1.0 + x)),
        ("profile", &|m, x| m.robot.tendons.profile[0].radius_m = 0.008 * (1.0 + x)),
    ];
    for (name, change) in changes {
        let by = |x: f64| (tip(&|m| change(m, x)) - home) / x;
        let (small, large) = (by(1e-4), by(1e-3));
        println!("{name}: {small:?}");
        assert!(small.norm() > 1e-6, "{name} does nothing");
        assert!((small - large).norm() < 0.05 * small.norm() + 2e-4, "{name}: {small} {large}");
    }
}

/// Cells that go across jumps of the material bend, twist and shorten the rod as those do that end
/// there.
#[test]
fn cells_across_jumps_stand_for_what_they_hold() {
    let nominal = [0.012, -0.004, -0.012, 0.004];
    let damaged = crate::support::rods::effects("- soft_section: {position_m: 0.09, scale: 0.3}");
    let robots = [
        (everything().rod(&[]), PULLS.to_vec()),
        (Model::default().rod(&[]), nominal.to_vec()),
        (Model::default().rod(&damaged), nominal.to_vec()),
    ];
    for (number, (mut params, pulls_m)) in robots.into_iter().enumerate() {
        params.resolution.static_tolerance_m = f64::INFINITY;
        let exact = settled(params.clone(), &pulls_m);
        let moved_m =
            (exact.tip_m() - settled(params.clone(), &vec![0.0; pulls_m.len()]).tip_m()).norm();
        for (cell_m, share) in [(0.03, 5e-4), (0.06, 3e-3)] {
            params.resolution.cell_m = cell_m;
            params.resolution.blended = true;
            let off_m = (settled(params.clone(), &pulls_m).tip_m() - exact.tip_m()).norm();
            assert!(off_m < share * moved_m, "{number}, cells of {cell_m} m: {off_m} of {moved_m}");
        }
    }
}
