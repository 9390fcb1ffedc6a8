//! Energy: never out of nothing. Robots let go with their drives held, histories over closed paths,
//! work against energy.

use crate::support::rods::random_robot::{bending_n_m2, log, robot};
use rand::RngExt;
use spinebench::base::Seed;
use spinebench::rod::{Drive, HistoryState, MomentLaw, Rod, RodParams, Scheme, SolveStatus};
use std::sync::Arc;

/// Mechanical energy with that of the drives that hold a tension, J.
fn energy_j(rod: &Rod, drives: &[Drive]) -> f64 {
    let energy = rod.energy();
    let held: f64 = drives
        .iter()
        .zip(rod.following_pulls_m())
        .map(
            |(drive, taken_in)| {
                if let Drive::Tension(tension) = drive { tension * taken_in } else { 0.0 }
            },
        )
        .sum();
    energy.kinetic_j + energy.elastic_j + energy.gravitational_j - held
}

/// First period of the rod as a cantilever, about, s.
fn period_s(params: &RodParams) -> f64 {
    let mass: f64 = params.spans.iter().map(|span| span.mass_kg_m).fold(0.0, f64::max)
        * params.length_m()
        + params.masses.iter().map(|mass| mass.mass_kg).sum::<f64>();
    1.8 * (mass * params.length_m().powi(3) / bending_n_m2(params)).sqrt()
}

/// A random robot bent by one tendon and let go: the drives jump and are held. Returns the largest
/// rise of its energy in one step over the energy set free; none if a solve was refused.
fn largest_rise(seed: Seed, damped: bool, scheme: Scheme, steps_a_period: f64) -> Option<f64> {
    let mut random = seed.rng();
    let mut params = robot(&mut random);
    params.moment_laws.clear();
    params.damping_time_s =
        if damped { log(&mut random, 0.003, 0.1) * period_s(&params) } else { 0.0 };
    let h = period_s(&params) / steps_a_period;
    params.resolution.scheme = scheme;
    params.resolution.time_step_s = h;
    params.resolution.motion_tolerance_m = f64::INFINITY;
    params.resolution.static_tolerance_m = f64::INFINITY;
    let count = params.tendons.len();
    let ([x, y], _) = params.tendons[0].path.at(0.0);
    let pull_n = 1.5 * bending_n_m2(&params) / (params.length_m() * x.hypot(y));
    let by_length = random.random_range(0..2) == 0;
    let mut rod = Rod::new(params);
    let mut drives = vec![Drive::Tension(0.0); count];
    drives[0] = Drive::Tension(pull_n);
    if rod.settle(&drives) != SolveStatus::Converged {
        return None;
    }
    drives = vec![if by_length { Drive::Pull(0.0) } else { Drive::Tension(0.0) }; count];
    if rod.advance(&drives, h) != SolveStatus::Converged {
        return None;
    }
    let mut levels = vec![energy_j(&rod, &drives)];
    for _ in 0..(2.0 * steps_a_period) as usize {
        if rod.advance(&drives, h) != SolveStatus::Converged {
            return None;
        }
        levels.push(energy_j(&rod, &drives));
    }
    let lowest = levels.iter().copied().fold(f64::INFINITY, f64::min);
    let free = levels[0] - lowest + rod_scale_j(&rod);
    let rise = levels.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    Some(rise / free)
}

/// Energy of the rod bent by a milliradian: what counts as none.
fn rod_scale_j(rod: &Rod) -> f64 {
    0.5e-6 * bending_n_m2(rod.params()) / rod.params().length_m()
}

/// Scheme, steps in a first period, whether damped, largest rise allowed as a share of the energy
/// set free.
const SWINGS: [(Scheme, f64, bool, f64); 6] = [
    (Scheme::Euler, 40.0, true, 1e-9),
    (Scheme::Euler, 40.0, false, 1e-9),
    (Scheme::Sdirk2, 40.0, true, 1e-9),
    (Scheme::Sdirk2, 40.0, false, 5e-3),
    (Scheme::Sdirk3, 40.0, true, 1e-9),
    (Scheme::Sdirk3, 40.0, false, 5e-3),
];

#[test]
fn robots_let_go_with_their_drives_held_lose_energy() {
    for (scheme, steps, damped, allowed) in SWINGS {
        let rises: Vec<f64> = (0..12)
            .filter_map(|k| largest_rise(Seed(21).index(k), damped, scheme, steps))
            .collect();
        println!("{scheme:?}, {steps} steps, damped {damped}: {rises:?}");
        assert!(rises.len() >= 7, "{scheme:?}: only {} robots moved", rises.len());
        assert!(rises.iter().all(|rise| *rise < allowed), "{scheme:?} damped {damped}: {rises:?}");
    }
}

fn laws() -> Vec<(&'static str, Arc<dyn MomentLaw>)> {
    let texts = [
        ("friction", "- friction: {moment_nm: 0.01, yield_rad_m: 0.3}"),
        ("coupled friction", "- friction: {moment_nm: 0.01, yield_rad_m: 0.3, coupled: true}"),
        ("hysteresis", "- hysteresis: {share: 0.3, range_rad_m: 2.0}"),
        ("creep", "- creep: {share: 0.4, time_s: 2.0}"),
    ];
    let mut laws = Vec::new();
    for (name, text) in texts {
        let specs = crate::support::rods::effects(text);
        let mut rod = crate::support::rods::round_rod(0.22, 2e-3, 2.33e9, 0.84e9, 0.05);
        specs[0].build().modify_rod(&mut rod);
        laws.extend(rod.moment_laws.into_iter().map(|law| (name, law)));
    }
    laws
}

/// Material that starts virgin can give back no more than was put in, whatever the path and however
/// it is cut into steps.
#[test]
fn histories_give_back_less_than_they_take() {
    const BENDING_N_M2: f64 = 0.03;
    for (name, law) in laws() {
        for k in 0..50 {
            let mut random = Seed(22).index(k).rng();
            let stride = log(&mut random, 1e-3, 2.0);
            let (mut state, mut u, mut work): (HistoryState, _, f64) = ([0.0; 4], [0.0, 0.0], 0.0);
            let mut move_to = |to: [f64; 2], dt_s: f64, work: &mut f64, u: &mut [f64; 2]| {
                let history = law.moment(&state, to, BENDING_N_M2).moment_nm;
                for axis in 0..2 {
                    *work += (history[axis] + BENDING_N_M2 * to[axis]) * (to[axis] - u[axis]);
                }
                law.commit(&mut state, to, BENDING_N_M2, dt_s);
                *u = to;
            };
            for _ in 0..300 {
                let to =
                    u.map(|x: f64| (x + random.random_range(-stride..stride)).clamp(-4.0, 4.0));
                move_to(to, log(&mut random, 1e-3, 10.0), &mut work, &mut u);
            }
            let start = u;
            for step in 1..=500 {
                let left = 1.0 - f64::from(step) / 500.0;
                move_to(start.map(|x| left * x), 1e-3, &mut work, &mut u);
            }
            // Closed: back at no curvature, where the elastic energy is what it was.
            assert!(work > -1e-12, "{name}, path {k}: {work} J/m came out of nothing");
        }
    }
}

/// Energy that enters through the drives while they move, against the rise of the mechanical
/// energy.
fn unaccounted(steps: usize) -> f64 {
    let mut params = crate::support::rods::shipped("nominal");
    params.sections.clear();
    params.damping_time_s = 0.0;
    params.resolution.motion_tolerance_m = f64::INFINITY;
    let duration_s = 0.4;
    let h = duration_s / steps as f64;
    params.resolution.time_step_s = h;
    params.tendons.iter_mut().for_each(|tendon| tendon.compliance_m_per_n = 1e-3);
    let mut rod = Rod::new(params);
    let pulls = |t: f64| {
        let share = 0.5 - 0.5 * (std::f64::consts::PI * t / duration_s).cos();
        [0.012, 0.004, -0.012, -0.004].map(|pull| Drive::Pull(share * pull))
    };
    assert_eq!(rod.settle(&pulls(0.0)), SolveStatus::Converged);
    let total = |rod: &Rod| {
        let energy = rod.energy();
        energy.kinetic_j + energy.elastic_j + energy.gravitational_j
    };
    let (start, mut work) = (total(&rod), 0.0);
    for k in 0..steps {
        let now = k as f64 * h;
        let before = rod.tensions_n().to_vec();
        assert_eq!(rod.advance_with(&|t| pulls(now + t).to_vec(), h), SolveStatus::Converged);
        for (i, (from, to)) in pulls(now).iter().zip(pulls(now + h)).enumerate() {
            if let (Drive::Pull(from), Drive::Pull(to)) = (from, to) {
                work += 0.5 * (before[i] + rod.tensions_n()[i]) * (to - from);
            }
        }
    }
    let gained = total(&rod) - start;
    println!("{steps} steps: {work:.6e} J of work, {gained:.6e} J gained");
    (work - gained).abs() / work.abs()
}

#[test]
fn the_work_of_the_drives_is_found_again_as_energy() {
    let shares = [40, 160, 640].map(unaccounted);
    assert!(shares[2] < 5e-3, "{shares:?} of the work unaccounted for");
    assert!(
        shares[1] < 0.5 * shares[0] && shares[2] < 0.5 * shares[1],
        "{shares:?} does not converge"
    );
}

/// A robot that has come to rest in a bowl of its energy stays there: no step adds to it.
#[test]
fn rest_gains_nothing() {
    let mut rod = Rod::new(crate::support::rods::shipped("real"));
    let drives = [0.01, -0.004, -0.01, 0.004].map(Drive::Pull);
    assert_eq!(rod.settle(&drives), SolveStatus::Converged);
    for _ in 0..20 {
        assert_eq!(rod.advance(&drives, 0.1), SolveStatus::Converged);
        assert!(rod.energy().kinetic_j < 1e-12, "{} J", rod.energy().kinetic_j);
    }
}
