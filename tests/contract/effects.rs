//! Contract of every effect in the catalogue.

use spinebench::base::{Plant, Seed};
use spinebench::effects::{CATALOGUE, Card, EffectSpec, Model, Seek};
use spinebench::plants::{Simulated, SimulatedOptions};

fn yaml<T: serde::de::DeserializeOwned>(text: &str) -> T {
    serde_yaml::with::singleton_map_recursive::deserialize(serde_yaml::Deserializer::from_str(text))
        .unwrap_or_else(|error| panic!("{error} in\n{text}"))
}

fn nominal() -> Model {
    yaml(include_str!("../../models/nominal.yaml"))
}

/// The effect with the given value for each of its parameters.
fn spec(card: &Card, value: &dyn Fn(&str, f64) -> f64) -> EffectSpec {
    let values: Vec<f64> =
        card.parameters.iter().map(|parameter| value(parameter.name, parameter.null)).collect();
    EffectSpec::from_card(card, &values).unwrap_or_else(|| panic!("{}: {values:?}", card.name))
}

/// A value at which an effect is clearly there.
fn strong(name: &str, null: f64) -> f64 {
    match name {
        "mass_kg" | "distance_m" => 0.02,
        "coupled" => 0.0,
        "tendon" => 2.0,
        "offset_m" | "width_m" => 0.002,
        "moment_nm" => 0.01,
        "compliance_m_per_n" => 2e-4,
        "position_m" => 0.06,
        "share" => 0.2,
        "ratio" => 0.15,
        "time_s" if null == 0.0 => 0.15,
        "time_s" => 3.0 * null,
        "range_rad_m" | "yield_rad_m" => null,
        _ if name.starts_with("force_n") => 0.1,
        _ if name.starts_with("shift_m") => 0.003,
        _ if name.starts_with("kappa") => 0.5,
        _ if name.ends_with("_rad") => 0.03,
        "scale" => 1.2,
        // A parameter of an effect that is added: ten times the change with which a search begins.
        _ => {
            let parameters = CATALOGUE.iter().flat_map(|card| card.parameters);
            let seek = parameters
                .filter(|parameter| parameter.name == name)
                .map(|parameter| parameter.seek)
                .next();
            match seek {
                Some(Seek::Size(first) | Seek::Scanned(first, _)) => null + 10.0 * first,
                Some(Seek::Shape(values)) => values[0],
                _ => null,
            }
        }
    }
}

/// Tips of a short trial with reversals.
fn tips(effects: &[EffectSpec]) -> Vec<[f64; 3]> {
    let mut plant = Simulated::new(&nominal(), effects, SimulatedOptions::default());
    let mut run = || {
        let mut tips = vec![plant.reset(Seed(5)).unwrap().tip_m];
        for k in 0..14 {
            let (a, b) = (0.012 * (0.6 * f64::from(k)).sin(), 0.009 * (0.45 * f64::from(k)).cos());
            tips.push(plant.step(&[a, b, -a, -b]).unwrap().tip_m);
        }
        tips
    };
    let (first, again) = (run(), run());
    assert_eq!(first, again, "a reset forgets, and the same commands give the same tips");
    first
}

/// Largest distance between two trials, metres.
fn apart_m(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.iter().zip(b).flat_map(|(p, q)| (0..3).map(|k| (p[k] - q[k]).abs())).fold(0.0, f64::max)
}

#[test]
fn at_its_null_value_an_effect_changes_nothing() {
    let plain = tips(&[]);
    for card in CATALOGUE {
        let apart = apart_m(&plain, &tips(&[spec(card, &|_, null| null)]));
        assert!(apart < 1e-6, "{}: {apart} m at its null value", card.name);
    }
}

#[test]
fn at_a_strong_value_an_effect_is_seen() {
    let plain = tips(&[]);
    for card in CATALOGUE {
        let apart = apart_m(&plain, &tips(&[spec(card, &strong)]));
        assert!(apart > 1e-4, "{}: only {apart} m at a strong value", card.name);
    }
}

#[test]
fn effects_survive_a_round_trip_through_yaml() {
    for card in CATALOGUE {
        let model = Model { effects: vec![spec(card, &strong)], ..nominal() };
        let text = spinebench::specs::model_text(&model).unwrap();
        assert_eq!(yaml::<Model>(&text), model, "{text}");
        assert!(text.contains(&format!("- {}:", card.name)), "{text}");
    }
}

#[test]
fn the_catalogue_is_complete_and_names_only_its_own() {
    let outside = [
        "tip_load",
        "distributed_mass",
        "tip_force",
        "base_tilt",
        "frame_shift",
        "bending_stiffness",
        "anisotropic_stiffness",
        "precurvature",
        "soft_section",
        "spine_compressibility",
        "friction",
        "hysteresis",
        "creep",
        "damping",
        "delay",
        "backlash",
        "actuator_gain",
        "actuator_offset",
        "tendon_stretch",
        "tendon_angle",
        "tendon_radius",
    ];
    let names: Vec<&str> = CATALOGUE.iter().map(|card| card.name).collect();
    assert_eq!(names[..outside.len()], outside);
    for card in CATALOGUE {
        assert!(card.confused_with.iter().all(|other| names.contains(other)), "{}", card.name);
        assert!(card.parameters.iter().all(|p| !p.unit.is_empty()), "{}", card.name);
    }
}

#[test]
fn the_default_robot_is_the_shipped_nominal_one() {
    assert_eq!(nominal(), Model::default());
}

#[test]
fn the_order_of_effects_means_nothing() {
    let own = [
        "tip_load",
        "distributed_mass",
        "bending_stiffness",
        "anisotropic_stiffness",
        "soft_section",
        "hysteresis",
        "creep",
    ];
    let effect = |name: &str| {
        let card = CATALOGUE.iter().find(|card| card.name == name).unwrap();
        spec(card, &|parameter, null| strong(parameter, null))
    };
    for (k, one) in own.iter().enumerate() {
        for other in &own[..k] {
            let (here, there) =
                (tips(&[effect(one), effect(other)]), tips(&[effect(other), effect(one)]));
            let apart = here
                .iter()
                .zip(&there)
                .flat_map(|(a, b)| (0..3).map(move |axis| (a[axis] - b[axis]).abs()));
            let most_m = apart.fold(0.0, f64::max);
            assert!(most_m < 1e-6, "{one} and {other}: {most_m} m");
        }
    }
}

/// The catalogue in the manual shows a picture of each.
#[test]
fn every_effect_has_its_picture() {
    let plots = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("plots/effects");
    for card in CATALOGUE {
        let picture = plots.join(format!("{}.svg", card.name));
        assert!(picture.is_file(), "{}: `make pages` draws it", picture.display());
    }
}
