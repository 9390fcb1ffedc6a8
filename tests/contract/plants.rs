//! What every plant of the registry keeps.

use spinebench::base::{Plant, PlantError, Seed, distance_m};
use spinebench::plants::{PlantSpec, REGISTRY};

/// Time of one step, s.
const STEP_S: f64 = 0.2;

/// The kinds of plant that this program can run by itself, with an example of each.
fn examples() -> Vec<(&'static str, PlantSpec)> {
    let examples = REGISTRY.iter().filter_map(|entry| Some((entry.name, (entry.example)()?)));
    let examples: Vec<_> = examples.collect();
    assert!(examples.len() >= 2);
    examples
}

#[test]
fn names_are_those_of_specs_and_options_are_in_range() {
    for (index, entry) in REGISTRY.iter().enumerate() {
        assert!(
            REGISTRY[..index].iter().all(|other| other.name != entry.name),
            "{} twice",
            entry.name
        );
    }
    for (name, spec) in examples() {
        assert_eq!(spec.kind(), name);
        assert_eq!(spec.check(), Ok(()), "{name}");
        let written = serde_json::to_value(&spec).unwrap();
        assert!(written.get(name).is_some(), "{name}: {written}");
        assert_eq!(serde_json::from_value::<PlantSpec>(written).unwrap(), spec, "{name}");
        let plant = spec.build(STEP_S).unwrap();
        assert_eq!((plant.tendons(), plant.step_s()), (spec.tendons(), STEP_S), "{name}");
        assert_eq!(spec.without_noise().check(), Ok(()), "{name}");
        assert_eq!(spec.identity(), spec.clone().identity(), "{name}");
    }
}

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
    for (name, spec) in examples() {
        let mut plant = spec.build(STEP_S).unwrap();
        let first = drive(plant.as_mut(), Seed(4));
        assert_eq!(first, drive(plant.as_mut(), Seed(4)), "{name}: reset brings it all back");
        assert_eq!(first, drive(spec.build(STEP_S).unwrap().as_mut(), Seed(4)), "{name}");
    }
}

#[test]
fn rest_stays_at_rest() {
    for (name, spec) in examples() {
        let mut plant = spec.build(STEP_S).unwrap();
        let home = plant.reset(Seed(4)).unwrap();
        assert_eq!(home.time_s, 0.0);
        let zero = vec![0.0; plant.tendons()];
        for step in 1..=20 {
            let seen = plant.step(&zero).unwrap();
            assert!((seen.time_s - plant.step_s() * f64::from(step)).abs() < 1e-9, "{name}");
            assert!(distance_m(&seen.tip_m, &home.tip_m) < 1e-6, "{name} moved");
        }
    }
}

#[test]
fn a_command_that_makes_no_sense_is_refused() {
    for (name, spec) in examples() {
        let mut plant = spec.build(STEP_S).unwrap();
        plant.reset(Seed(4)).unwrap();
        let few = vec![0.0; plant.tendons() - 1];
        assert!(matches!(plant.step(&few), Err(PlantError::Refused(_))), "{name}");
        let mut broken = vec![0.0; plant.tendons()];
        broken[0] = f64::NAN;
        assert!(matches!(plant.step(&broken), Err(PlantError::Refused(_))), "{name}");
    }
}
