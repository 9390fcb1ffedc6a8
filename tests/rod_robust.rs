//! Random commands over the whole allowed range: every solve ends converged or with a named status.

mod common;

use rand::RngExt;
use spinebench::base::{Plant, PlantError, Seed};
use spinebench::effects::Model;
use spinebench::plants::{Simulated, SimulatedOptions};

/// Plays random steps of up to 3 mm (all four tendons on their own, so also slack and against each other) and counts
/// the failures by name.
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
            Ok(seen) => assert!(seen.tip_m.iter().all(|x| x.is_finite() && x.abs() < 0.25), "{:?}", seen.tip_m),
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
    for name in ["nominal", "real"] {
        let failed = failures(&common::model(name), 2000, 1, 0.003, 0.001);
        assert!(failed.is_empty(), "{failed:?}");
    }
}

#[test]
fn violent_commands_are_solved_too() {
    let real = common::model("real");
    for (jump_m, own_m) in [(0.01, 0.003), (0.03, 0.003), (0.03, 0.01)] {
        let failed = failures(&real, 3000, 2, jump_m, own_m);
        assert!(failed.is_empty(), "jumps of {jump_m} m and {own_m} m: {failed:?}");
    }
}

#[test]
fn four_tendons_against_each_other_end_converged_or_named() {
    let mut plant = Simulated::new(&common::model("real"), &[], SimulatedOptions::default());
    let mut random = Seed(3).rng();
    let (mut failed, draws) = (0, 1500);
    for k in 0..draws {
        plant.reset(Seed(1)).unwrap();
        let scale = [0.004, 0.01, 0.02][k % 3];
        let pulls: Vec<f64> = (0..4).map(|_| random.random_range(-scale..scale)).collect();
        match plant.step(&pulls) {
            Ok(seen) => assert!(seen.tip_m.iter().all(|x| x.is_finite() && x.abs() < 0.25), "{pulls:?}"),
            Err(PlantError::Solver(_)) => failed += 1,
            Err(other) => panic!("{other}"),
        }
    }
    // Commands that crush the spine within one tick; far outside what a collection or a policy asks for.
    assert!(failed * 500 <= draws, "{failed} of {draws}");
}
