//! The moving rod: Till et al.'s example against its limit, orders of convergence, energy,
//! symmetry, rest.

use crate::support::rods::{reference, round_rod, shipped};
use nalgebra::Vector3;
use spinebench::rod::{Drive, Rod, RodParams, Scheme, SolveStatus};

/// Till et al.'s dynamic tendon example: one tendon, pulled and let go (reference README).
fn till_example(time_step_s: f64, scheme: Scheme) -> RodParams {
    let mut params = shipped("till_dynamic");
    params.resolution.time_step_s = time_step_s;
    params.resolution.scheme = scheme;
    params.resolution.motion_tolerance_m = f64::INFINITY;
    params
}

const RAMP_ENDS_S: [f64; 4] = [3.652, 3.967, 17.63, 17.94];

/// Drive displacement of that example, metres; the ramp lies between the 20 Hz samples of the
/// reference.
fn till_pull_m(t: f64) -> f64 {
    let ramp = |from: f64, to: f64| ((t - from) / (to - from)).clamp(0.0, 1.0);
    0.01619 * (ramp(RAMP_ENDS_S[0], RAMP_ENDS_S[1]) - ramp(RAMP_ENDS_S[2], RAMP_ENDS_S[3]))
}

/// Root mean square distance of the tip from the limit series, metres.
fn till_error_m(params: RodParams) -> f64 {
    let rows = reference("till_dynamic_example_limit.csv");
    let mut rod = Rod::new(params);
    assert_eq!(rod.settle(&[Drive::Pull(0.0)]), SolveStatus::Converged);
    let (mut sum, mut now) = (0.0, 0.0);
    for row in &rows {
        let t = row["t"];
        if t > now {
            // Steps end where the ramps do: a kink inside a step would cost an order.
            let window = now..t;
            for end in RAMP_ENDS_S.into_iter().filter(|end| window.contains(end)).chain([t]) {
                let start = now;
                let status =
                    rod.advance_with(&|dt| vec![Drive::Pull(till_pull_m(start + dt))], end - now);
                assert_eq!(status, SolveStatus::Converged, "at {t} s");
                now = end;
            }
        }
        let p = rod.tip_m();
        sum += (p.x - row["px"]).powi(2) + (p.z - row["pz"]).powi(2);
    }
    (sum / rows.len() as f64).sqrt()
}

#[test]
fn tills_example_converges_to_its_limit() {
    let coarse = till_error_m(till_example(0.05, Scheme::Sdirk2));
    let fine = till_error_m(till_example(0.0025, Scheme::Sdirk2));
    println!("{coarse} m at 50 ms, {fine} m at 2.5 ms");
    // At its own 50 ms the published scheme is 17 mm from the limit.
    assert!(coarse < 4e-3, "{coarse} m rms at 50 ms");
    assert!(fine < 1e-4, "{fine} m rms at 2.5 ms");
}

#[test]
fn tills_example_is_right_as_its_model_is_shipped() {
    let error = till_error_m(shipped("till_dynamic"));
    println!("{error} m with steps as long as their error allows");
    assert!(error < 1e-4, "{error} m rms");
}

/// The paper's robot, for what follows.
fn nominal() -> RodParams {
    shipped("nominal")
}

/// Tip after half a second of a smooth pull.
fn after_smooth_pull(scheme: Scheme, time_step_s: f64) -> Vector3<f64> {
    let mut params = nominal();
    params.resolution.scheme = scheme;
    params.resolution.time_step_s = time_step_s;
    params.resolution.motion_tolerance_m = f64::INFINITY;
    // No compressible sections: their saturation would be a kink in time.
    params.sections.clear();
    let mut rod = Rod::new(params);
    let pull = |t: f64| 0.01 * (0.5 - 0.5 * (std::f64::consts::PI * t / 0.5).cos());
    let drives = |t: f64| vec![Drive::Pull(pull(t)), Drive::Follow, Drive::Follow, Drive::Follow];
    assert_eq!(rod.settle(&drives(0.0)), SolveStatus::Converged);
    assert_eq!(rod.advance_with(&drives, 0.5), SolveStatus::Converged);
    rod.tip_m()
}

#[test]
fn schemes_converge_at_their_order_in_time() {
    for (scheme, order) in [(Scheme::Euler, 1.0), (Scheme::Sdirk2, 2.0)] {
        let steps = [0.02, 0.01, 0.005];
        let tips = steps.map(|dt| after_smooth_pull(scheme, dt));
        let observed = ((tips[0] - tips[1]).norm() / (tips[1] - tips[2]).norm()).log2();
        println!("{scheme:?}: order {observed:.2}");
        assert!((observed - order).abs() < 0.35, "{scheme:?}: order {observed}");
    }
}

#[test]
fn space_converges_at_fourth_order_in_cells_and_spectrally_in_polynomials() {
    let tip = |cell_m: f64, bending_modes: usize| {
        let mut params = round_rod(0.22, 2e-3, 2.33e9, 0.84e9, 0.2);
        params.gravity_m_s2 = Vector3::new(-9.81, 0.0, 0.0);
        params.resolution.cell_m = cell_m;
        params.resolution.bending_modes = bending_modes;
        params.resolution.static_tolerance_m = f64::INFINITY;
        params.tip_load.force_n = Vector3::new(0.3, 0.8, -0.2);
        let mut rod = Rod::new(params);
        assert_eq!(rod.settle(&[]), SolveStatus::Converged);
        rod.tip_m()
    };
    let cells = [0.044, 0.022, 0.011].map(|cell| tip(cell, 10));
    let order = ((cells[0] - cells[1]).norm() / (cells[1] - cells[2]).norm()).log2();
    assert!((order - 4.0).abs() < 0.4, "order {order} in the cell length");
    let best = tip(0.011, 12);
    let errors = [3, 5, 7].map(|modes| (tip(0.011, modes) - best).norm());
    assert!(
        errors[1] < 0.1 * errors[0] && errors[2] < 0.1 * errors[1],
        "{errors:?} m with 3, 5, 7 polynomials"
    );
}

#[test]
fn energy_decays_when_the_robot_is_let_go() {
    let mut params = nominal();
    params.resolution.time_step_s = 0.005;
    params.damping_time_s = 0.01;
    let mut rod = Rod::new(params);
    let hold = [Drive::Tension(4.0), Drive::Tension(3.0), Drive::Tension(0.0), Drive::Tension(0.0)];
    assert_eq!(rod.settle(&hold), SolveStatus::Converged);
    let total = |rod: &Rod| {
        let e = rod.energy();
        e.kinetic_j + e.elastic_j + e.gravitational_j
    };
    let (start, mut before) = (total(&rod), total(&rod));
    for step in 0..200 {
        assert_eq!(rod.advance(&[Drive::Tension(0.0); 4], 0.005), SolveStatus::Converged);
        let now = total(&rod);
        assert!(now <= before + 1e-9, "step {step}: from {before} J to {now} J");
        before = now;
    }
    assert!(before < start - 1e-3, "{start} J to {before} J");
}

/// Moves the drives at constant speed within 20 ms, and then holds them for 0.4 s.
fn moved(rod: &mut Rod, from: &[f64; 4], to: &[f64; 4]) -> SolveStatus {
    let drives =
        |t: f64| (0..4).map(|i| Drive::Pull(from[i] + (to[i] - from[i]) * t / 0.02)).collect();
    match rod.advance_with(&drives, 0.02) {
        SolveStatus::Converged => rod.advance(&to.map(Drive::Pull), 0.4),
        failure => failure,
    }
}

#[test]
fn a_quarter_turn_of_gravity_and_commands_turns_the_answer() {
    let run = |turned: bool| {
        let mut params = nominal();
        let mut drives = [0.012, -0.004, -0.011, 0.006];
        if turned {
            params.gravity_m_s2 = Vector3::new(0.0, -9.81, 0.0);
            drives.rotate_right(1);
        }
        let mut rod = Rod::new(params);
        assert_eq!(rod.settle(&[Drive::Pull(0.0); 4]), SolveStatus::Converged);
        assert_eq!(moved(&mut rod, &[0.0; 4], &drives), SolveStatus::Converged);
        rod.tip_m()
    };
    let (plain, turned) = (run(false), run(true));
    let expected = Vector3::new(-plain.y, plain.x, plain.z);
    assert!((turned - expected).norm() < 1e-8, "{turned} against {expected}");
}

#[test]
fn rest_stays_at_rest() {
    let mut rod = Rod::new(nominal());
    let drives = [0.01, 0.005, -0.012, -0.006].map(Drive::Pull);
    assert_eq!(rod.settle(&drives), SolveStatus::Converged);
    let tip = rod.tip_m();
    for _ in 0..20 {
        assert_eq!(rod.advance(&drives, 0.2), SolveStatus::Converged);
    }
    assert!((rod.tip_m() - tip).norm() < 1e-8, "moved by {} m", (rod.tip_m() - tip).norm());
    assert!(rod.energy().kinetic_j < 1e-12);
}

#[test]
fn a_very_short_time_changes_nothing() {
    let mut rod = Rod::new(nominal());
    let pulls = [0.005_45, 0.002_15, -0.005_45, -0.002_15];
    assert_eq!(rod.settle(&[Drive::Pull(0.0); 4]), SolveStatus::Converged);
    assert_eq!(moved(&mut rod, &[0.0; 4], &pulls), SolveStatus::Converged);
    let drives = pulls.map(Drive::Pull);
    let mut interrupted = rod.clone();
    for duration_s in [2e-7, 1e-8, 3e-6, 1e-9] {
        assert_eq!(
            interrupted.advance(&drives, duration_s),
            SolveStatus::Converged,
            "{duration_s} s"
        );
    }
    for _ in 0..5 {
        assert_eq!(rod.advance(&drives, 0.02), SolveStatus::Converged);
        assert_eq!(interrupted.advance(&drives, 0.02), SolveStatus::Converged);
        let apart_m = (rod.tip_m() - interrupted.tip_m()).norm();
        assert!(apart_m < 1e-4, "{apart_m} m");
    }
}

#[test]
fn tendons_pull_and_never_push() {
    let mut rod = Rod::new(nominal());
    assert_eq!(rod.settle(&[Drive::Pull(0.0); 4]), SolveStatus::Converged);
    let mut before = [0.0; 4];
    for drives in [[-0.01; 4], [0.02, -0.03, -0.02, 0.01], [0.004; 4], [-0.02, 0.0, 0.03, 0.0]] {
        assert_eq!(moved(&mut rod, &before, &drives), SolveStatus::Converged);
        before = drives;
        assert!(rod.tensions_n().iter().all(|&tension| tension >= 0.0), "{:?}", rod.tensions_n());
        let slack = rod.tensions_n().iter().zip(rod.following_pulls_m()).zip(drives);
        for ((&tension, following), pull) in slack {
            // What is let out further than the shape needs is slack, and what is slack carries
            // nothing.
            assert!(
                tension == 0.0 || (pull - following).abs() < 1e-7,
                "{tension} N at {pull} m, shape asks {following}"
            );
        }
    }
}

#[test]
fn commands_that_are_not_finite_are_refused() {
    let mut rod = Rod::new(nominal());
    let bad = [Drive::Pull(f64::NAN), Drive::Follow, Drive::Follow, Drive::Follow];
    assert_eq!(rod.settle(&bad), SolveStatus::BadCommand);
    assert_eq!(rod.advance(&[Drive::Tension(-1.0); 4], 0.2), SolveStatus::BadCommand);
    assert_eq!(rod.settle(&[Drive::Follow; 3]), SolveStatus::BadCommand);
}

#[test]
fn the_spine_shortens_by_its_compliance_and_stops_at_saturation() {
    // Straight, no gravity: four equal tensions compress every section alike (eq. 14).
    for (each_n, per_section_m) in [(1.0, 4.0 * 2e-4), (4.0, 16.0 * 2e-4), (6.0, 20.0 * 2e-4)] {
        let mut params = nominal();
        params.gravity_m_s2 = Vector3::zeros();
        let axial_n = params.spans[0].axial_n;
        let mut rod = Rod::new(params);
        assert_eq!(rod.settle(&[Drive::Tension(each_n); 4]), SolveStatus::Converged);
        let expected = 0.22 - 11.0 * per_section_m - 0.22 * 4.0 * each_n / axial_n;
        assert!(
            (rod.tip_m().z - expected).abs() < 1e-8,
            "{} m against {expected} m",
            rod.tip_m().z
        );
    }
}
