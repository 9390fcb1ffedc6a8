//! What every policy of the registry keeps.

use crate::support::policies::{
    AnalyticInverse, BrokenInverse, ConstantError, exact_parts, inverse_mappings, policy, seen,
    told_of_model,
};
use proptest::prelude::*;
use spinebench::base::{Action, Point3, Policy, PolicyError};
use spinebench::policies::{
    BuildError, LimitOptions, ModelAccess, PolicyEntry, PolicyOptions, PolicyParts, REGISTRY, build,
};
use std::sync::Arc;

/// Parts whose memory shows in the command.
fn remembering_parts() -> PolicyParts {
    let parts = told_of_model(
        PolicyParts::default().with_error(Arc::new(ConstantError([0.01, 0.0, 0.002]))),
    );
    let model = || Box::new(AnalyticInverse { drift_m: 1e-4, ..AnalyticInverse::default() });
    inverse_mappings()
        .into_iter()
        .fold(parts, |parts, network| parts.with_inverse(network, model()))
}

fn play(policy: &mut dyn Policy, tips_m: &[Point3], target_m: &Point3) -> Vec<Action> {
    tips_m
        .iter()
        .enumerate()
        .map(|(step, tip_m)| policy.act(&seen(step, *tip_m), target_m).unwrap())
        .collect()
}

#[test]
fn names_are_unique() {
    for (index, entry) in REGISTRY.iter().enumerate() {
        assert!(
            REGISTRY[..index].iter().all(|other| other.name != entry.name),
            "{} twice",
            entry.name
        );
    }
}

#[test]
fn a_missing_part_is_named() {
    let needs = |entry: &&PolicyEntry| !entry.needs.is_empty() || entry.model != ModelAccess::None;
    for entry in REGISTRY.iter().filter(needs) {
        let Err(BuildError::Missing { policy, model }) =
            build(entry, PolicyParts::default(), &PolicyOptions::default())
        else {
            panic!("{} was built from nothing", entry.name)
        };
        assert_eq!(policy, entry.name);
        let told = ["error model", "tendon layout", "nominal model"];
        let named = told.contains(&model) || entry.networks().any(|network| network.name == model);
        assert!(named, "{}: {model}", entry.name);
    }
}

#[test]
fn an_option_out_of_range_is_refused() {
    for entry in REGISTRY {
        let mut options = PolicyOptions::default();
        options.limits.travel_m = -0.03;
        let Err(BuildError::Option(bad)) = build(entry, exact_parts([0.0; 3]), &options) else {
            panic!("{} took a negative travel", entry.name)
        };
        assert_eq!(bad.key, "travel_m");
    }
}

#[test]
fn an_observation_that_is_not_finite_is_an_error() {
    for entry in REGISTRY {
        let mut policy = policy(entry.name, exact_parts([0.0; 3]), &PolicyOptions::default());
        let blind = policy.act(&seen(0, [0.0, f64::NAN, 0.2]), &[0.05, 0.0, 0.2]);
        assert_eq!(blind, Err(PolicyError::NotFinite("measured tip")), "{}", entry.name);
        let lost = policy.act(&seen(0, [0.0, 0.0, 0.22]), &[f64::INFINITY, 0.0, 0.2]);
        assert_eq!(lost, Err(PolicyError::NotFinite("target")), "{}", entry.name);
    }
}

#[test]
fn a_network_that_goes_wrong_is_an_error() {
    for entry in REGISTRY {
        let parts =
            told_of_model(PolicyParts::default().with_error(Arc::new(ConstantError([0.0; 3]))));
        let broken =
            |parts: PolicyParts, network| parts.with_inverse(network, Box::new(BrokenInverse));
        let parts = inverse_mappings().into_iter().fold(parts, broken);
        let networks = entry.networks().count() > 0;
        let mut policy = policy(entry.name, parts, &PolicyOptions::default());
        let result = policy.act(&seen(0, [0.0, 0.0, 0.22]), &[0.05, 0.0, 0.2]);
        assert!(
            !networks || matches!(result, Err(PolicyError::NotFinite(_))),
            "{}: {result:?}",
            entry.name
        );
    }
}

#[test]
fn lost_tracking_before_the_first_measurement_is_an_error_and_later_is_not() {
    for entry in REGISTRY {
        let mut policy = policy(entry.name, exact_parts([0.0; 3]), &PolicyOptions::default());
        let mut lost = seen(0, [f64::NAN; 3]);
        lost.valid = false;
        let target_m = [0.05, 0.0, 0.2];
        assert_eq!(policy.act(&lost, &target_m), Err(PolicyError::NoMeasurement), "{}", entry.name);
        policy.act(&seen(0, [0.0, 0.0, 0.22]), &target_m).unwrap();
        policy.act(&lost, &target_m).unwrap();
    }
}

#[test]
fn reset_forgets() {
    let tips_m: Vec<Point3> = (0..12).map(|step| [0.004 * f64::from(step), 0.0, 0.22]).collect();
    for entry in REGISTRY {
        let mut policy = policy(entry.name, remembering_parts(), &PolicyOptions::default());
        policy.reset();
        let first = play(policy.as_mut(), &tips_m, &[0.06, 0.03, 0.2]);
        let again = play(policy.as_mut(), &tips_m, &[0.06, 0.03, 0.2]);
        assert!(entry.needs.is_empty() || first != again, "{}: nothing to forget", entry.name);
        play(policy.as_mut(), &tips_m, &[-0.02, 0.05, 0.2]);
        policy.reset();
        assert_eq!(first, play(policy.as_mut(), &tips_m, &[0.06, 0.03, 0.2]), "{}", entry.name);
    }
}

#[test]
fn branches_are_named_by_what_gave_the_command() {
    for (name, branch) in [("a", "a"), ("b", "b"), ("c", "a"), ("pi_real", "")] {
        let mut policy = policy(name, exact_parts([0.0; 3]), &PolicyOptions::default());
        let action = policy.act(&seen(0, [0.0, 0.0, 0.22]), &[0.05, 0.0, 0.2]).unwrap();
        assert_eq!(action.branch, branch, "{name}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn commands_are_finite_and_within_the_limits(
        tips_m in prop::collection::vec(prop::array::uniform3(-0.5..0.5_f64), 1..30),
        target_m in prop::array::uniform3(-2.0..2.0_f64),
        step_m in prop::option::of(1e-4..0.01_f64),
    ) {
        let limits = LimitOptions { travel_m: 0.02, max_step_m: step_m };
        let options = PolicyOptions { limits, ..PolicyOptions::default() };
        for entry in REGISTRY {
            let mut policy = policy(entry.name, remembering_parts(), &options);
            let mut last = vec![0.0; 4];
            for action in play(policy.as_mut(), &tips_m, &target_m) {
                for (now, before) in action.pulls_m.iter().zip(&last) {
                    prop_assert!(now.abs() <= 0.02, "{}: {now}", entry.name);
                    prop_assert!((now - before).abs() <= step_m.unwrap_or(0.04) + 1e-15, "{}", entry.name);
                }
                last = action.pulls_m;
            }
        }
    }
}
