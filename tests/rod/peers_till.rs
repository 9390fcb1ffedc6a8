//! The other scheme of the comparison (`benches/peers/till`) is itself right: it finds the
//! published limit and our equilibria.

#[path = "../../benches/peers/till/mod.rs"]
mod till;

use crate::support::rods::{reference, shipped, vector};
use nalgebra::Vector3;
use spinebench::rod::{Drive, Rod, SolveStatus};
use till::{Settings, Solver, Space, Till};

/// Through the first ramp of the example and the swing after it.
const DURATION_S: f64 = 6.0;

fn pull_m(t: f64) -> f64 {
    0.01619 * ((t - 3.652) / (3.967 - 3.652)).clamp(0.0, 1.0)
}

/// Root mean square distance of the tip from the limit series, metres.
fn error_m(settings: Settings) -> f64 {
    let rows = reference("till_dynamic_example_limit.csv");
    let mut rod = Till::<1>::new(&shipped("till_dynamic"), settings).unwrap();
    rod.settle(&[Drive::Pull(0.0)]).unwrap();
    let (mut sum, mut count) = (0.0, 0.0);
    let each = (0.05 / settings.time_step_s).round() as usize;
    for pair in rows.windows(2).filter(|pair| pair[0]["t"] >= 0.0 && pair[1]["t"] <= DURATION_S) {
        for k in 1..=each {
            let t = pair[0]["t"] + 0.05 * k as f64 / each as f64;
            rod.step(&[Drive::Pull(pull_m(t))]).unwrap();
        }
        let wanted = Vector3::new(pair[1]["px"], 0.0, pair[1]["pz"]);
        sum += (rod.tip_m() - wanted).norm_squared();
        count += 1.0;
    }
    f64::sqrt(sum / count)
}

#[test]
fn its_refinement_finds_the_limit_of_its_example() {
    let fine = Settings {
        space: Space::Rk4,
        nodes: 40,
        solver: Solver::Newton,
        extrapolate: true,
        ..Settings::published()
    };
    let errors = [0.05, 0.01, 0.0025].map(|time_step_s| error_m(Settings { time_step_s, ..fine }));
    println!("{errors:?} m at 50, 10 and 2.5 ms");
    assert!(errors[0] > 1e-2, "{errors:?} m");
    assert!(errors[1] < 0.12 * errors[0] && errors[2] < 0.3 * errors[1], "{errors:?} m");
    assert!(errors[2] < 3e-4, "{errors:?} m");
}

#[test]
fn at_its_own_settings_it_errs_as_is_known() {
    // Over the whole example it is 17 mm rms; its own spatial error at rest is 1.5 mm.
    let settings = Settings { solver: Solver::Newton, ..Settings::published() };
    let error = error_m(settings);
    assert!((0.012..0.025).contains(&error), "{error} m");
    let mut rod = Till::<1>::new(&shipped("till_dynamic"), settings).unwrap();
    rod.settle(&[Drive::Pull(0.0)]).unwrap();
    let rest = vector(&reference("till_dynamic_example_limit.csv")[0], ["px", "px", "pz"]);
    let off = Vector3::new(rod.tip_m().x - rest.x, 0.0, rod.tip_m().z - rest.z).norm();
    assert!((1e-3..2e-3).contains(&off), "{off} m at rest");
}

#[test]
fn the_papers_robot_rests_where_ours_does() {
    // Compressible spine, slack tendons, jumps of the material: nothing of the two solvers is
    // shared but the numbers.
    let params = shipped("nominal");
    let settings = Settings {
        space: Space::Rk4,
        nodes: 96,
        solver: Solver::Newton,
        tolerance: 1e-16,
        rotary_inertia: false,
        linear_damping: true,
        ..Settings::published()
    };
    let mut shooting = Till::<4>::new(&params, settings).unwrap();
    let mut ours = Rod::new(params);
    for pulls in [
        [0.0; 4],
        [0.005, 0.002, -0.005, -0.002],
        [0.012, -0.008, -0.012, 0.008],
        [-0.02, 0.004, 0.02, -0.004],
    ] {
        let drives = pulls.map(Drive::Pull);
        shooting.settle(&drives).unwrap();
        assert_eq!(ours.settle(&drives), SolveStatus::Converged);
        let off = (shooting.tip_m() - ours.tip_m()).norm();
        assert!(off < 1e-6, "{off} m apart at {pulls:?}");
        let tensions = shooting.tensions_n();
        for (i, tension) in ours.tensions_n().iter().enumerate() {
            assert!(
                (tensions[i] - tension).abs() < 1e-3,
                "{tensions:?} N against {:?}",
                ours.tensions_n()
            );
        }
    }
}

#[test]
fn the_papers_robot_moves_as_ours_does() {
    let params = shipped("nominal");
    let settings = Settings {
        space: Space::Rk4,
        nodes: 24,
        solver: Solver::Newton,
        time_step_s: 0.0025,
        rotary_inertia: false,
        linear_damping: true,
        ..Settings::published()
    };
    let drives = |t: f64| [0.01 * t, 0.006 * t, -0.01 * t, -0.006 * t].map(Drive::Pull).to_vec();
    let mut shooting = Till::<4>::new(&params, settings).unwrap();
    let mut ours = Rod::new(params);
    shooting.settle(&drives(0.0)).unwrap();
    assert_eq!(ours.settle(&drives(0.0)), SolveStatus::Converged);
    for k in 0..10 {
        let start = 0.05 * f64::from(k);
        for step in 1..=20 {
            shooting.step(&drives(start + 0.0025 * f64::from(step))).unwrap();
        }
        assert_eq!(ours.advance_with(&|t| drives(start + t), 0.05), SolveStatus::Converged);
        let off = (shooting.tip_m() - ours.tip_m()).norm();
        assert!(off < 1e-4, "{off} m apart after {start} s and 50 ms");
    }
}
