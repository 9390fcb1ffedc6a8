//! The moving rod: Till et al.'s example against its limit, orders of convergence, energy, symmetry, rest.

mod common;

use common::{reference, round_rod};
use nalgebra::Vector3;
use spinebench::rod::{Drive, Rod, RodParams, Scheme, Status, Tendon};

/// Till et al.'s dynamic tendon example: one tendon, pulled and let go (reference README).
fn till_example(time_step_s: f64, scheme: Scheme) -> RodParams {
    let mut params = round_rod(0.7144, 0.675e-3, 207e9, 207e9 / 2.6, 0.034 / 0.7144);
    params.gravity_m_s2 = Vector3::new(-9.81, 0.0, 0.0);
    params.damping_time_s = 5e-4 / params.spans[0].bending_n_m2[0];
    params.drag_n_s2_m3 = 1e-4;
    params.tendons = vec![Tendon {
        offset_m: [0.01506, 0.0],
        end_m: 0.7144,
        pretension_m: 0.0,
        compliance_m_per_n: 1e-4 * (0.7144 + 0.0518),
        elastic_length_m: 0.7144 + 0.0518,
    }];
    params.resolution.time_step_s = time_step_s;
    params.resolution.scheme = scheme;
    params
}

const RAMP_ENDS_S: [f64; 4] = [3.652, 3.967, 17.63, 17.94];

/// Drive displacement of that example, metres; the ramp lies between the 20 Hz samples of the reference.
fn till_pull_m(t: f64) -> f64 {
    let ramp = |from: f64, to: f64| ((t - from) / (to - from)).clamp(0.0, 1.0);
    0.01619 * (ramp(RAMP_ENDS_S[0], RAMP_ENDS_S[1]) - ramp(RAMP_ENDS_S[2], RAMP_ENDS_S[3]))
}

/// Root mean square distance of the tip from the limit series, metres.
fn till_error_m(time_step_s: f64, scheme: Scheme) -> f64 {
    let rows = reference("till_dynamic_example_limit.csv");
    let mut rod = Rod::new(till_example(time_step_s, scheme));
    assert_eq!(rod.settle(&[Drive::Pull(0.0)]), Status::Converged);
    let (mut sum, mut now) = (0.0, 0.0);
    for row in &rows {
        let t = row["t"];
        if t > now {
            // Steps end where the ramps do: a kink inside a step would cost an order.
            let window = now..t;
            for end in RAMP_ENDS_S.into_iter().filter(|end| window.contains(end)).chain([t]) {
                let start = now;
                let status = rod.advance_with(&|dt| vec![Drive::Pull(till_pull_m(start + dt))], end - now);
                assert_eq!(status, Status::Converged, "at {t} s");
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
    for scheme in [Scheme::Sdirk2, Scheme::Sdirk3] {
        for dt in [0.05, 0.025, 0.0125, 0.00625, 0.003125] {
            let start = std::time::Instant::now();
            let error = till_error_m(dt, scheme);
            println!("{scheme:?} dt {dt}: {:.4} mm rms, {:.2} s", error * 1e3, start.elapsed().as_secs_f64());
        }
    }
    assert!(till_error_m(0.0125, Scheme::Sdirk3) < 1e-4);
}
