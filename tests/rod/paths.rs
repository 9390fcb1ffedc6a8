//! Tendons on any path, tapering rods and loads anywhere, against the strong form of Rucker &
//! Webster (2011) and the energy balance.

use crate::support::shooting::{Cord, Pose, Shooting, Stiffness};
use nalgebra::{Matrix3, Vector3, Vector6};
use spinebench::rod::{
    Drive, LineLoad, PathPoint, PointLoad, Rod, RodParams, SolveStatus, Span, Taper, Tendon,
    TendonPath, TipWrench,
};
use std::f64::consts::PI;

const LENGTH_M: f64 = 0.36;
const E_PA: f64 = 6e5;
const G_PA: f64 = 6e5 / 2.9;
const POSITION_M: f64 = 1e-6;
const ROTATION: f64 = 1e-5;

/// A cone of soft rubber.
fn cone(radii_m: [f64; 2]) -> RodParams {
    let mut params = crate::support::rods::round_rod(LENGTH_M, radii_m[0], E_PA, G_PA, 0.0);
    params.spans[0].taper = Taper { outer: radii_m, inner: [0.0; 2] };
    params
}

/// Its stiffness and how that changes, for the oracle.
fn cone_stiffness(radii_m: [f64; 2], anisotropy: f64) -> Stiffness {
    Box::new(move |s| {
        let slope = (radii_m[1] - radii_m[0]) / LENGTH_M;
        let a = radii_m[0] + slope * s;
        let (area, inertia) = (PI * a * a, 0.25 * PI * a.powi(4));
        let (bend, twist) = (E_PA * inertia, 2.0 * G_PA * inertia);
        let k = Vector6::new(
            bend * (1.0 + anisotropy),
            bend * (1.0 - anisotropy),
            twist,
            G_PA * area,
            G_PA * area,
            E_PA * area,
        );
        let powers = Vector6::new(4.0, 4.0, 4.0, 2.0, 2.0, 2.0);
        (k, k.component_mul(&powers) * (slope / a))
    })
}

fn oracle(radii_m: [f64; 2]) -> Shooting {
    Shooting {
        stiffness: cone_stiffness(radii_m, 0.0),
        rest: Box::new(|_| Vector3::zeros()),
        cords: Vec::new(),
        line: Box::new(|_| Vector3::zeros()),
        points: Vec::new(),
        tip_force: Vector3::zeros(),
        tip_moment: Vector3::zeros(),
        follows: false,
        borders: vec![0.0, LENGTH_M],
        steps: 400,
        share: 1.0,
    }
}

/// Straight lines between points, for the oracle.
fn polyline(points: &'static [[f64; 3]]) -> crate::support::shooting::Path {
    Box::new(move |s| {
        let next = points.iter().position(|p| p[0] > s).unwrap_or(points.len());
        if next == 0 || next == points.len() {
            let p = points[next.min(points.len() - 1)];
            return [Vector3::new(p[1], p[2], 0.0), Vector3::zeros(), Vector3::zeros()];
        }
        let (a, b) = (points[next - 1], points[next]);
        let slope = Vector3::new(b[1] - a[1], b[2] - a[2], 0.0) / (b[0] - a[0]);
        [Vector3::new(a[1], a[2], 0.0) + slope * (s - a[0]), slope, Vector3::zeros()]
    })
}

fn tendon(points: &[[f64; 3]], start_m: f64, end_m: f64) -> Tendon {
    let points = points.iter().map(|&[s_m, x, y]| PathPoint { s_m, offset_m: [x, y] }).collect();
    Tendon {
        path: TendonPath { points, twist_rad_m: 0.0 },
        start_m,
        ..Tendon::parallel([0.0; 2], end_m)
    }
}

/// Settled at a resolution that resolves a soft cone bent double.
fn settled(mut params: RodParams, tensions_n: &[f64]) -> Rod {
    params.resolution.bending_modes = 12;
    params.resolution.torsion_modes = 12;
    params.resolution.shear_modes = 12;
    params.resolution.axial_modes = 12;
    params.resolution.cell_m = 0.005;
    let mut rod = Rod::new(params);
    let drives: Vec<Drive> = tensions_n.iter().map(|&tension| Drive::Tension(tension)).collect();
    assert_eq!(rod.settle(&drives), SolveStatus::Converged);
    rod
}

fn compare(what: &str, rod: &Rod, expected: &Pose) {
    let position = (rod.tip_m() - expected.p).norm();
    let turn = (rod.tip_rotation() - expected.r).norm();
    let bend = (rod.tip_rotation() - Matrix3::identity()).norm();
    println!("{what}: {position:.2e} m {turn:.2e}, tip at {:?}, turned {bend:.2}", rod.tip_m());
    assert!(bend > 0.3, "{what}: hardly bent, {bend}");
    assert!(position < POSITION_M && turn < ROTATION, "{what}: {position:e} m, {turn:e}");
}

const CONVERGING: [&[[f64; 3]]; 2] = [
    &[[0.0, 0.010, 0.0057], [LENGTH_M, 0.001, 0.0007]],
    &[[0.0, -0.010, 0.0057], [LENGTH_M, -0.001, 0.0007]],
];

#[test]
fn converging_tendons_in_a_cone_under_its_weight() {
    let radii = [0.0154, 0.0048];
    let mut params = cone(radii);
    params.spans[0].mass_kg_m = 1500.0 * PI * radii[0] * radii[0];
    params.gravity_m_s2 = Vector3::new(-6.0, 0.0, -7.0);
    params.tendons = CONVERGING.iter().map(|points| tendon(points, 0.0, LENGTH_M)).collect();
    params.tip_load.force_n = Vector3::new(0.02, -0.03, 0.01);
    let tensions = [4.0, 1.5];
    let mut shot = oracle(radii);
    shot.tip_force = params.tip_load.force_n;
    shot.line = Box::new(move |s| {
        let a = radii[0] + (radii[1] - radii[0]) * s / LENGTH_M;
        Vector3::new(-6.0, 0.0, -7.0) * (1500.0 * PI * a * a)
    });
    shot.cords = CONVERGING
        .iter()
        .zip(tensions)
        .map(|(points, tension_n)| Cord {
            path: polyline(points),
            start_m: 0.0,
            end_m: LENGTH_M,
            tension_n,
        })
        .collect();
    compare("cone", &settled(params, &tensions), &shot.solve());
}

#[test]
fn a_helical_tendon_twists_and_bends() {
    let radii = [0.01, 0.006];
    let (radius, twist) = (0.008, 12.0);
    let mut params = cone(radii);
    let mut helix = Tendon::parallel([radius, 0.0], LENGTH_M);
    helix.path.twist_rad_m = twist;
    params.tendons = vec![helix, Tendon::parallel([0.0, 0.004], LENGTH_M)];
    params.tip_load.moment_nm = Vector3::new(0.0, 1e-3, 2e-3);
    let tensions = [2.0, 0.5];
    let mut shot = oracle(radii);
    shot.tip_moment = params.tip_load.moment_nm;
    let path: crate::support::shooting::Path = Box::new(move |s| {
        let (sin, cos) = (twist * s).sin_cos();
        let r = Vector3::new(cos, sin, 0.0) * radius;
        [r, Vector3::new(-sin, cos, 0.0) * (radius * twist), r * (-twist * twist)]
    });
    shot.cords = vec![
        Cord { path, start_m: 0.0, end_m: LENGTH_M, tension_n: tensions[0] },
        Cord {
            path: polyline(&[[0.0, 0.0, 0.004]]),
            start_m: 0.0,
            end_m: LENGTH_M,
            tension_n: tensions[1],
        },
    ];
    compare("helix", &settled(params, &tensions), &shot.solve());
}

/// A kink inside, one tendon that ends part-way where another goes on, one that starts part-way, a
/// load between.
#[test]
fn kinks_ends_starts_and_loads_inside_jump_as_they_should() {
    const KINKED: &[[f64; 3]] =
        &[[0.0, 0.009, 0.0], [0.12, 0.004, 0.005], [LENGTH_M, 0.003, -0.002]];
    const SHORT: &[[f64; 3]] = &[[0.0, -0.005, 0.006], [0.24, -0.002, 0.0045]];
    const LATE: &[[f64; 3]] = &[[0.08, 0.0, -0.006], [0.3, 0.002, -0.003]];
    let radii = [0.012, 0.007];
    let (anisotropy, rest) = (0.2, Vector3::new(1.0, -2.0, 1.5));
    let mut params = cone(radii);
    let stiffness = params.spans[0].bending_n_m2[0];
    params.spans[0] = Span {
        bending_n_m2: [stiffness * (1.0 + anisotropy), stiffness * (1.0 - anisotropy)],
        rest_curvature_rad_m: rest,
        ..params.spans[0].clone()
    };
    params.tendons =
        vec![tendon(KINKED, 0.0, LENGTH_M), tendon(SHORT, 0.0, 0.24), tendon(LATE, 0.08, 0.3)];
    let (force, moment) = (Vector3::new(-0.1, 0.15, 0.05), Vector3::new(2e-3, 1e-3, -3e-3));
    params.point_loads =
        vec![PointLoad { position_m: 0.2, force_n: force, moment_nm: moment, follows: false }];
    let line = Vector3::new(0.0, 0.3, -0.5);
    params.line_loads = vec![LineLoad { start_m: 0.05, end_m: 0.15, force_n_m: line }];
    let tensions = [2.5, 2.0, 1.5];
    let mut shot = oracle(radii);
    shot.stiffness = cone_stiffness(radii, anisotropy);
    shot.rest = Box::new(move |_| rest);
    shot.points = vec![(0.2, force, moment)];
    shot.line = Box::new(move |s| if (0.05..0.15).contains(&s) { line } else { Vector3::zeros() });
    shot.borders = vec![0.0, 0.05, 0.08, 0.12, 0.15, 0.2, 0.24, 0.3, LENGTH_M];
    shot.steps = 100;
    shot.cords = [(KINKED, 0.0, LENGTH_M), (SHORT, 0.0, 0.24), (LATE, 0.08, 0.3)]
        .into_iter()
        .zip(tensions)
        .map(|((points, start_m, end_m), tension_n)| Cord {
            path: polyline(points),
            start_m,
            end_m,
            tension_n,
        })
        .collect();
    compare("kinks", &settled(params, &tensions), &shot.solve());
}

#[test]
fn a_follower_load_turns_with_its_cross_section() {
    let radii = [0.01, 0.006];
    let mut params = cone(radii);
    let (force, moment) = (Vector3::new(0.12, 0.05, -0.04), Vector3::new(0.0, 2e-3, 3e-3));
    params.point_loads =
        vec![PointLoad { position_m: LENGTH_M, force_n: force, moment_nm: moment, follows: true }];
    let mut shot = oracle(radii);
    (shot.tip_force, shot.tip_moment, shot.follows) = (force, moment, true);
    let mut rod = settled(params, &[]);
    compare("follower", &rod, &shot.solve());
    // A derivative that did not see the load turn would not contract.
    let before = rod.effort();
    rod.set_tip_load(TipWrench {
        force_n: Vector3::new(1e-3, 1e-3, 0.0),
        moment_nm: Vector3::zeros(),
    });
    assert_eq!(rod.settle(&[]), SolveStatus::Converged);
    let after = rod.effort();
    let (iterations, derivatives) =
        (after.iterations - before.iterations, after.derivatives - before.derivatives);
    println!("a little more load: {iterations} iterations, {derivatives} derivatives");
    assert!(iterations <= 5, "{iterations} iterations");
}

/// What tendons take in times their tension is what the rod stores, whatever their paths.
#[test]
fn the_work_of_the_tendons_is_the_energy_stored() {
    let mut params = cone([0.0154, 0.0048]);
    params.tendons = CONVERGING.iter().map(|points| tendon(points, 0.0, LENGTH_M)).collect();
    params.tendons[1].path.twist_rad_m = 8.0;
    let mut rod = Rod::new(params);
    let mut worked_j = 0.0;
    let steps = 400;
    let mut before = vec![0.0; 2];
    for k in 0..=steps {
        let share = f64::from(k) / f64::from(steps);
        let tensions = [5.0 * share, 3.0 * share * share];
        let drives = tensions.map(Drive::Tension);
        assert_eq!(rod.settle(&drives), SolveStatus::Converged);
        let pulls = rod.following_pulls_m();
        let share_before = f64::from(k - 1) / f64::from(steps);
        let tensions_before = [5.0 * share_before, 3.0 * share_before * share_before];
        if k > 0 {
            worked_j += (0..2)
                .map(|i| 0.5 * (tensions[i] + tensions_before[i]) * (pulls[i] - before[i]))
                .sum::<f64>();
        } else {
            assert!(pulls.iter().all(|pull| pull.abs() < 1e-12), "{pulls:?} at home");
        }
        before = pulls;
    }
    let stored_j = rod.energy().elastic_j;
    println!("worked {worked_j:.9} J, stored {stored_j:.9} J");
    assert!(
        stored_j > 0.01 && (worked_j / stored_j - 1.0).abs() < 1e-5,
        "{worked_j} against {stored_j}"
    );
}

/// A tapering span is the limit of many uniform ones, also after it has been split.
#[test]
fn a_taper_is_no_staircase_and_survives_a_split() {
    let tip = |pieces: usize, split: bool| {
        let mut params = cone([0.0154, 0.0048]);
        params.spans[0].mass_kg_m = 0.8;
        params.gravity_m_s2 = Vector3::new(-9.81, 0.0, 0.0);
        if split {
            [0.11, 0.23, 0.234].iter().for_each(|&s| params.split_at(s));
            assert_eq!(params.spans.len(), 4);
        }
        if pieces > 0 {
            let at = |k: usize| params.span_at(LENGTH_M * (k as f64 + 0.5) / pieces as f64);
            let end_m = |k: usize| LENGTH_M * (k + 1) as f64 / pieces as f64;
            params.spans = (0..pieces)
                .map(|k| Span { end_m: end_m(k), taper: Taper::NONE, ..at(k) })
                .collect();
        }
        settled(params, &[]).tip_m()
    };
    let exact = tip(0, false);
    assert!((exact - tip(0, true)).norm() < 1e-7);
    let (coarse, fine) = ((tip(30, false) - exact).norm(), (tip(120, false) - exact).norm());
    println!("staircases of 30 and 120: {coarse:.2e}, {fine:.2e}");
    assert!(coarse > 1e-6 && fine < 0.1 * coarse, "{coarse:e} {fine:e}");
}

/// The pose inside cells continues that at their ends, and its derivative is the strain.
#[test]
fn poses_are_given_everywhere() {
    let mut params = cone([0.0154, 0.0048]);
    params.spans[0].mass_kg_m = 0.8;
    params.gravity_m_s2 = Vector3::new(-6.0, 0.0, -7.0);
    params.tendons = CONVERGING.iter().map(|points| tendon(points, 0.0, LENGTH_M)).collect();
    let rod = settled(params, &[4.0, 1.5]);
    let (tip, turn) = rod.pose_at(LENGTH_M);
    assert!((tip - rod.tip_m()).norm() < 1e-15 && (turn - rod.tip_rotation()).norm() < 1e-14);
    assert_eq!(rod.pose_at(0.0), (Vector3::zeros(), Matrix3::identity()));
    for section in rod.cross_sections() {
        let (position, rotation) = rod.pose_at(section.s_m);
        // Positions at Gauss points take the tangent as linear in the cell; poses do not.
        assert!(
            (position - section.position_m).norm() < 1e-6
                && (rotation - section.rotation).norm() < 1e-14
        );
    }
    // Across the border of two cells and inside one, a hundredth of a millimetre apart.
    for s in [0.1, 0.101, 0.2222] {
        let [before, here, after] = [s - 1e-5, s, s + 1e-5].map(|s| rod.pose_at(s).0);
        assert!(
            (after - here * 2.0 + before).norm() < 1e-8,
            "{s}: {:e}",
            (after - here * 2.0 + before).norm()
        );
    }
}

/// Poses inside cells are of third order, and at the usual length of cells (12.5 mm) within what
/// the rod allows itself (1 µm), in a soft cone that hangs and is bent.
#[test]
fn poses_inside_cells_are_accurate() {
    let bent = |cells: f64| {
        let mut params = cone([0.0154, 0.0048]);
        params.spans[0].mass_kg_m = 0.8;
        params.gravity_m_s2 = Vector3::new(-6.0, 0.0, -7.0);
        params.tendons = CONVERGING.iter().map(|points| tendon(points, 0.0, LENGTH_M)).collect();
        params.resolution.cell_m = LENGTH_M / cells;
        params.resolution.static_tolerance_m = f64::INFINITY;
        let mut rod = Rod::new(params);
        assert_eq!(rod.settle(&[Drive::Tension(4.0), Drive::Tension(1.5)]), SolveStatus::Converged);
        rod
    };
    let exact = bent(480.0);
    let worst = |rod: Rod| {
        let places = (1..24).map(|k| LENGTH_M * (f64::from(k) + 0.37) / 24.0);
        places.map(|s_m| (rod.pose_at(s_m).0 - exact.pose_at(s_m).0).norm()).fold(0.0, f64::max)
    };
    let [coarse, fine] = [15.0, 30.0].map(|cells| worst(bent(cells)));
    println!("{coarse:.2e}, {fine:.2e}");
    assert!(fine < 0.15 * coarse && fine < 1e-6, "{coarse:e} {fine:e}");
}
