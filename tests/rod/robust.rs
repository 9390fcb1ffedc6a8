//! Random commands over the whole allowed range: every solve ends converged or with a named status.

use nalgebra::Vector3;
use rand::RngExt;
use spinebench::base::{Plant, PlantError, Seed};
use spinebench::effects::Model;
use spinebench::plants::{Simulated, SimulatedOptions};
use spinebench::rod::{Drive, Rod, SolveStatus, TipWrench};

/// Plays random steps of up to 3 mm (all four tendons on their own, so also slack and against each
/// other) and counts the failures by name.
fn failures(
    model: &Model,
    steps: usize,
    seed: u64,
    jump_m: f64,
    own_m: f64,
) -> std::collections::BTreeMap<String, usize> {
    let mut plant = Simulated::new(model, &[], SimulatedOptions::default());
    let mut random = Seed(seed).rng();
    let mut failures = std::collections::BTreeMap::new();
    let mut pulls = [0.0_f64; 4];
    plant.reset(Seed(seed)).unwrap();
    for step in 0..steps {
        if step % 50 == 0 {
            pulls = [0.0; 4];
            plant.reset(Seed(seed)).unwrap();
        }
        let bend = [random.random_range(-jump_m..jump_m), random.random_range(-jump_m..jump_m)];
        for (i, pull) in pulls.iter_mut().enumerate() {
            let sign = if i < 2 { 1.0 } else { -1.0 };
            let own: f64 = random.random_range(-own_m..own_m);
            *pull = (*pull + sign * bend[i % 2] + own).clamp(-0.03, 0.03);
        }
        match plant.step(&pulls) {
            Ok(seen) => assert!(
                seen.tip_m.iter().all(|x| x.is_finite() && x.abs() < 0.25),
                "{:?}",
                seen.tip_m
            ),
            Err(PlantError::Solver(name)) => {
                println!("step {step}: {name} at {pulls:?}");
                *failures.entry(name).or_insert(0) += 1;
                pulls = [0.0; 4];
                plant.reset(Seed(seed)).unwrap();
            }
            Err(other) => panic!("{other}"),
        }
    }
    failures
}

#[test]
fn random_commands_never_fail_inside_the_workspace() {
    let steps = std::env::var("WORKSPACE_STEPS")
        .map_or(2000, |steps| steps.parse().expect("a number of steps"));
    for name in ["nominal", "real"] {
        let failed = failures(&crate::support::rods::model(name), steps, 1, 0.003, 0.001);
        assert!(failed.is_empty(), "{failed:?}");
    }
}

#[test]
fn violent_commands_are_solved_too() {
    let real = crate::support::rods::model("real");
    for (jump_m, own_m) in [(0.01, 0.003), (0.03, 0.003), (0.03, 0.01)] {
        let failed = failures(&real, 3000, 2, jump_m, own_m);
        assert!(failed.is_empty(), "jumps of {jump_m} m and {own_m} m: {failed:?}");
    }
}

#[test]
fn four_tendons_against_each_other_end_converged_or_named() {
    let mut plant =
        Simulated::new(&crate::support::rods::model("real"), &[], SimulatedOptions::default());
    let mut random = Seed(3).rng();
    let (mut failed, draws) = (0, 1500);
    for k in 0..draws {
        plant.reset(Seed(1)).unwrap();
        let scale = [0.004, 0.01, 0.02][k % 3];
        let pulls: Vec<f64> = (0..4).map(|_| random.random_range(-scale..scale)).collect();
        match plant.step(&pulls) {
            Ok(seen) => {
                assert!(seen.tip_m.iter().all(|x| x.is_finite() && x.abs() < 0.25), "{pulls:?}")
            }
            Err(PlantError::Solver(_)) => failed += 1,
            Err(other) => panic!("{other}"),
        }
    }
    // Commands that crush the spine within one tick; far outside what a collection or a policy asks
    // for.
    assert!(failed * 500 <= draws, "{failed} of {draws}");
}

/// A column that its own weight buckles (w L³ > 7.84 E I) does not stand.
#[test]
fn a_column_too_heavy_to_stand_falls_to_one_side() {
    let upright = |weight: f64| {
        let mut params = crate::support::rods::round_rod(0.3, 2e-3, 2.33e9, 0.84e9, 0.0);
        let stiffness = params.spans[0].bending_n_m2[0];
        params.spans[0].mass_kg_m = weight * stiffness / (9.81 * 0.3_f64.powi(3));
        params.gravity_m_s2 = Vector3::new(0.0, 0.0, -9.81);
        let mut rod = Rod::new(params);
        assert_eq!(rod.settle(&[]), SolveStatus::Converged);
        rod.tip_m()
    };
    let (light, heavy) = (upright(7.0), upright(9.0));
    assert!(light.xy().norm() < 1e-9, "{light}");
    assert!(heavy.xy().norm() > 0.05, "{heavy}");
}

/// Where disks would have to meet at the inside of the bend, the answer is a name.
#[test]
fn a_rod_bent_tighter_than_its_tendons_run_is_crushed() {
    let mut params = crate::support::rods::round_rod(0.22, 2e-3, 2.33e9, 0.84e9, 0.05);
    params.tendons = crate::support::rods::four_tendons(0.02, 0.22, 0.0);
    let mut rod = Rod::new(params);
    let pull = |each: f64| [each, 0.0, -2.0 * each, 0.0].map(Drive::Pull);
    assert_eq!(rod.settle(&pull(0.05)), SolveStatus::Converged);
    assert_eq!(rod.settle(&pull(0.30)), SolveStatus::Crushed);
}

/// A string held out at its base and hanging from there, softer and softer, with tendons that
/// nobody pulls. Tips of the boundary value problem of a planar rod with stretch and shear, solved
/// by collocation (SciPy's `solve_bvp`, tolerance 1e-8).
#[test]
fn a_hanging_string_comes_to_rest() {
    const LENGTH_M: f64 = 0.7144;
    const HANGING_M: [(f64, [f64; 2]); 4] = [
        (1e8, [-0.69221666, 0.05461689]),
        (3e7, [-0.70251023, 0.02921524]),
        (1e7, [-0.70783385, 0.01668098]),
        (5e6, [-0.71016732, 0.01174145]),
    ];
    for (youngs_modulus_pa, [x_m, z_m]) in HANGING_M {
        let radius_m = 0.000675_f64;
        let mass_kg_m = 1200.0 * std::f64::consts::PI * radius_m.powi(2);
        let shear_modulus_pa = youngs_modulus_pa / (2.0 * 1.49);
        let mut params = crate::support::rods::round_rod(
            LENGTH_M,
            radius_m,
            youngs_modulus_pa,
            shear_modulus_pa,
            mass_kg_m,
        );
        params.gravity_m_s2 = Vector3::new(-9.81, 0.0, 0.0);
        params.tendons = crate::support::rods::four_tendons(0.0151, LENGTH_M, 0.0);
        let mut rod = Rod::new(params);
        assert_eq!(
            rod.settle(&[Drive::Tension(0.0); 4]),
            SolveStatus::Converged,
            "{youngs_modulus_pa} Pa"
        );
        let off_m = (rod.tip_m() - Vector3::new(x_m, 0.0, z_m)).norm();
        assert!(off_m < 1e-6, "{youngs_modulus_pa} Pa: {off_m} m off");
    }
}

/// Tendons askew over a jump of stiffness: the coarse grid is off by more than the tolerance, and
/// the rod notices.
#[test]
fn statics_refine_themselves_where_the_grid_is_too_coarse() {
    let mut params = crate::support::rods::round_rod(0.3, 1.5e-3, 2.33e9, 0.84e9, 0.05);
    params.split_at(0.14);
    params.spans[1].bending_n_m2 = params.spans[1].bending_n_m2.map(|stiffness| 0.4 * stiffness);
    params.spans[1].torsion_n_m2 *= 0.4;
    params.gravity_m_s2 = Vector3::new(-9.81, 0.0, 0.0);
    params.tendons = crate::support::rods::four_tendons(0.02, 0.3, 0.0);
    let load = TipWrench {
        force_n: Vector3::new(0.0, 0.15, 0.1),
        moment_nm: Vector3::new(0.0, 0.0, 0.01),
    };
    let settle = |tolerance_m: f64| {
        let mut params = params.clone();
        params.resolution.static_tolerance_m = tolerance_m;
        let mut rod = Rod::new(params);
        rod.set_tip_load(load);
        assert_eq!(rod.settle(&[6.0, 1.0, 0.0, 0.0].map(Drive::Tension)), SolveStatus::Converged);
        rod
    };
    let (coarse, fine, finest) = (settle(f64::INFINITY), settle(1e-6), settle(1e-9));
    let off = |rod: &Rod| (rod.tip_m() - finest.tip_m()).norm();
    println!(
        "{:e} m coarse, {:e} m fine, estimates {:e} {:e}",
        off(&coarse),
        off(&fine),
        coarse.space_error_m(),
        fine.space_error_m()
    );
    assert_eq!(coarse.refinements(), 0);
    assert!(off(&coarse) > 1e-6 && coarse.space_error_m() > off(&coarse), "{:e} m", off(&coarse));
    assert!(fine.refinements() > 0 && off(&fine) < 1e-6, "{:e} m", off(&fine));
    assert!(fine.space_error_m() < 1e-6);
}

#[test]
fn a_rod_that_remembers_moves_on_its_own_grid() {
    let yaml = "- friction: {moment_nm: 0.0128, yield_rad_m: 0.1}\n- tip_load: {mass_kg: 0.0065}";
    let mut rod =
        Rod::new(crate::support::rods::model("nominal").rod(&crate::support::rods::effects(yaml)));
    let drives = [0.01, 0.0, -0.01, 0.0].map(Drive::Pull);
    assert_eq!(rod.settle(&drives), SolveStatus::Converged);
    let tip_m = rod.tip_m();
    assert!(
        rod.refinements() > 0,
        "friction leaves kinks at rest that its own grid does not resolve"
    );
    assert_eq!(rod.advance(&drives, 0.2), SolveStatus::Converged);
    assert_eq!(rod.refinements(), 0);
    assert!(
        (rod.tip_m() - tip_m).norm() < 1e-3,
        "its histories came along: {} m",
        (rod.tip_m() - tip_m).norm()
    );
}

/// Newton's method goes back and forth between two branches of a friction that hardly yields; steps
/// must not become short for that.
#[test]
fn friction_that_hardly_yields_takes_few_more_iterations_than_one_that_does() {
    let iterations = |yaml: &str| {
        let mut params =
            crate::support::rods::model("nominal").rod(&crate::support::rods::effects(yaml));
        params.resolution.motion_tolerance_m = 3e-4;
        let mut rod = Rod::new(params);
        let mut random = Seed(5).rng();
        assert_eq!(rod.settle(&[Drive::Pull(0.0); 4]), SolveStatus::Converged);
        for _ in 0..40 {
            let [x, y] = std::array::from_fn(|_| random.random_range(-0.012..0.012));
            assert_eq!(
                rod.advance(&[x, y, -x, -y].map(Drive::Pull), 0.2),
                SolveStatus::Converged,
                "{yaml}"
            );
        }
        rod.effort().iterations
    };
    let [hardly, soon] = ["0.02", "0.5"].map(|yields| {
        iterations(&format!("- friction: {{moment_nm: 0.0123, yield_rad_m: {yields}}}"))
    });
    println!("{hardly} iterations where friction hardly yields, {soon} where it does");
    assert!(hardly < 3 * soon, "{hardly} iterations of {soon}");
}
#[test]
fn friction_settles_however_little_it_yields() {
    for yields in [0.5, 0.1, 0.02] {
        for moment in [0.002, 0.006, 0.0123, 0.03] {
            let yaml = format!("- friction: {{moment_nm: {moment}, yield_rad_m: {yields}}}");
            let mut rod = Rod::new(
                crate::support::rods::model("nominal").rod(&crate::support::rods::effects(&yaml)),
            );
            assert_eq!(rod.settle(&[Drive::Pull(0.0); 4]), SolveStatus::Converged, "{yaml}");
            assert!(rod.space_error_m() < 1e-4, "{yaml}: {:e} m", rod.space_error_m());
        }
    }
}
