//! Policies from outside: held to the limits, faults as named statuses.

use crate::support::policies::seen;
use spinebench::base::PolicyError;
use spinebench::policies::{
    LimitOptions, OnnxInput, OnnxOptions, OnnxOutput, OutsidePolicy, PolicyOptions,
};
use std::path::PathBuf;

const TORCH: &[u8] = include_bytes!("../data/onnx/torch_policy.onnx");

fn options() -> OnnxOptions {
    OnnxOptions {
        closed_loop_only: false,
        file: PathBuf::from("torch_policy.onnx"),
        inputs: vec![OnnxInput::Tip, OnnxInput::Target, OnnxInput::Pulls],
        output: OnnxOutput::Pulls,
        position_scale_m: 0.2,
        pull_scale_m: 0.03,
        settled_m: 0.001,
    }
}

#[test]
fn a_network_is_held_to_the_limits_of_the_drive() {
    let limits = LimitOptions { travel_m: 0.005, max_step_m: Some(0.001) };
    let shared = PolicyOptions { limits, ..PolicyOptions::default() };
    let mut policy = OutsidePolicy::Onnx(options()).build(TORCH, 4, &shared).unwrap();
    policy.reset();
    let mut last = vec![0.0; 4];
    for _ in 0..20 {
        let action = policy.act(&seen(0, [0.0, 0.0, 0.2]), &[0.05, 0.0, 0.2]).unwrap();
        for (now, before) in action.pulls_m.iter().zip(&last) {
            assert!(
                now.abs() <= 0.005 && (now - before).abs() <= 0.001 + 1e-12,
                "{now} after {before}"
            );
        }
        last = action.pulls_m;
    }
    assert!(last.iter().any(|pull| *pull != 0.0));
}

#[test]
fn numbers_that_are_not_finite_are_a_status() {
    let mut policy =
        OutsidePolicy::Onnx(options()).build(TORCH, 4, &PolicyOptions::default()).unwrap();
    policy.reset();
    let error = policy.act(&seen(0, [f64::NAN, 0.0, 0.2]), &[0.0; 3]).unwrap_err();
    assert_eq!(error, PolicyError::NotFinite("measured tip"));
    let tiny = OnnxOptions { pull_scale_m: 1e-300, position_scale_m: 1e-320, ..options() };
    let mut policy = OutsidePolicy::Onnx(tiny).build(TORCH, 4, &PolicyOptions::default()).unwrap();
    policy.reset();
    let error = policy.act(&seen(0, [0.01, 0.0, 0.2]), &[0.05, 0.0, 0.2]).unwrap_err();
    assert_eq!(error, PolicyError::NotFinite("output of the network"));
}

#[test]
fn a_network_of_another_size_is_refused_with_both_sizes() {
    let check = |options: OnnxOptions, tendons| {
        OutsidePolicy::Onnx(options).check_content(TORCH, tendons).unwrap_err()
    };
    let (found, expected) = check(OnnxOptions { inputs: vec![OnnxInput::Error], ..options() }, 4);
    assert!(
        found.contains("10 inputs") && expected.contains("3, the size of `inputs`"),
        "{found}, {expected}"
    );
    // Six tendons with six numbers of positions would be twelve inputs; without positions the
    // outputs do not fit.
    let ten_pulls = OnnxOptions { inputs: vec![OnnxInput::Pulls], ..options() };
    let (found, expected) = check(ten_pulls, 10);
    assert!(
        found.contains("4 outputs") && expected.contains("10, one for each tendon"),
        "{found}, {expected}"
    );
}

#[test]
fn changes_of_commands_are_for_closed_loop_only() {
    let entry = |output, closed_loop_only| {
        let options = OnnxOptions { output, closed_loop_only, ..options() };
        OutsidePolicy::Onnx(options).entry().closed_loop_only
    };
    assert!(entry(OnnxOutput::Changes, false) && !entry(OnnxOutput::Pulls, false));
    assert!(entry(OnnxOutput::Pulls, true));
}
