//! What every plant of the registry keeps.

use spinebench::base::{Plant, PlantError, Seed, distance_m};
use spinebench::plants::REGISTRY;

/// A few steps of 2 mm on one pair of tendons, the opposite ones let out.
fn drive(plant: &mut dyn Plant, seed: Seed) -> Vec<spinebench::base::Observation> {
    let mut seen = vec![plant.reset(seed).unwrap()];
    for step in 0..8 {
        let pull_m = 0.002 * f64::from(step);
        let tendons = plant.tendons();
        let pulls_m: Vec<f64> = (0..tendons)
            .map(|index| {
                if index == 0 {
                    pull_m
                } else if index == tendons / 2 {
                    -pull_m
                } else {
                    0.0
                }
            })
            .collect();
        seen.push(plant.step(&pulls_m).unwrap());
    }
    seen
}

#[test]
fn the_same_seed_gives_the_same_trajectory() {
    for entry in REGISTRY {
        let mut plant = (entry.example)();
        let first = drive(plant.as_mut(), Seed(4));
        assert_eq!(first, drive(plant.as_mut(), Seed(4)), "{}: reset brings it all back", entry.name);
        assert_eq!(first, drive((entry.example)().as_mut(), Seed(4)), "{}", entry.name);
    }
}

#[test]
fn rest_stays_at_rest() {
    for entry in REGISTRY {
        let mut plant = (entry.example)();
        let home = plant.reset(Seed(4)).unwrap();
        assert_eq!(home.time_s, 0.0);
        let zero = vec![0.0; plant.tendons()];
        for step in 1..=20 {
            let seen = plant.step(&zero).unwrap();
            assert!((seen.time_s - plant.step_s() * f64::from(step)).abs() < 1e-9, "{}", entry.name);
            assert!(distance_m(&seen.tip_m, &home.tip_m) < 1e-6, "{} moved", entry.name);
        }
    }
}

#[test]
fn a_command_that_makes_no_sense_is_refused() {
    for entry in REGISTRY {
        let mut plant = (entry.example)();
        plant.reset(Seed(4)).unwrap();
        let few = vec![0.0; plant.tendons() - 1];
        assert!(matches!(plant.step(&few), Err(PlantError::Refused(_))), "{}", entry.name);
        let mut broken = vec![0.0; plant.tendons()];
        broken[0] = f64::NAN;
        assert!(matches!(plant.step(&broken), Err(PlantError::Refused(_))), "{}", entry.name);
    }
}
