//! Policies from outside: held to the limits, faults as named statuses.

use crate::support::policies::seen;
use spinebench::base::PolicyError;
use spinebench::policies::{
    LimitOptions, OnnxInput, OnnxInputs, OnnxOptions, OnnxOutput, OnnxWindow, OutsidePolicy,
    PolicyOptions, ProcessOptions,
};
use std::path::PathBuf;

const TORCH: &[u8] = include_bytes!("../data/onnx/torch_policy.onnx");

fn options() -> OnnxOptions {
    OnnxOptions {
        closed_loop_only: false,
        file: PathBuf::from("torch_policy.onnx"),
        inputs: OnnxInputs::default(),
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
        OutsidePolicy::Onnx(options)
            .check_content(TORCH, tendons, &ProcessOptions::default())
            .unwrap_err()
    };
    let (found, expected) =
        check(OnnxOptions { inputs: OnnxInputs::Now(vec![OnnxInput::Error]), ..options() }, 4);
    assert!(
        found.contains("10 inputs") && expected.contains("3, the size of `inputs`"),
        "{found}, {expected}"
    );
    // Six tendons with six numbers of positions would be twelve inputs; without positions the
    // outputs do not fit.
    let ten_pulls = OnnxOptions { inputs: OnnxInputs::Now(vec![OnnxInput::Pulls]), ..options() };
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

/// The commands of ten ticks with a tip that moves.
fn commands(policy: &mut dyn spinebench::base::Policy) -> Vec<Vec<f64>> {
    let tip = |tick: usize| [0.004 * tick as f64, 0.001, 0.2];
    let act = |tick| policy.act(&seen(tick, tip(tick)), &[0.05, 0.0, 0.2]).unwrap().pulls_m;
    (0..10).map(act).collect()
}

#[test]
fn a_network_with_memory_remembers_a_trial_and_forgets_it_at_the_next() {
    const LSTM: &[u8] = include_bytes!("../data/onnx/torch_lstm.onnx");
    const STATES: &[u8] = include_bytes!("../data/onnx/torch_lstm_states.onnx");
    const WINDOW: &[u8] = include_bytes!("../data/onnx/torch_gru_window.onnx");
    let window = OnnxInputs::Past(OnnxWindow {
        window: 5,
        each: vec![OnnxInput::Tip, OnnxInput::Target, OnnxInput::Pulls],
    });
    for (bytes, inputs) in
        [(LSTM, OnnxInputs::default()), (STATES, OnnxInputs::default()), (WINDOW, window)]
    {
        let options = OnnxOptions { inputs, ..options() };
        let built = OutsidePolicy::Onnx(options).build(bytes, 4, &PolicyOptions::default());
        let mut policy = built.unwrap();
        policy.reset();
        let first = commands(policy.as_mut());
        let going_on = commands(policy.as_mut());
        policy.reset();
        assert_eq!(commands(policy.as_mut()), first, "a trial begins anew");
        assert_ne!(going_on, first, "what was before it counts");
    }
    // The window of a network without memory: the rows before, the oldest first.
    let (found, expected) = OutsidePolicy::Onnx(OnnxOptions {
        inputs: OnnxInputs::Past(OnnxWindow { window: 2, each: vec![OnnxInput::Tip] }),
        ..options()
    })
    .check_content(TORCH, 4, &ProcessOptions::default())
    .unwrap_err();
    assert!(found.contains("10 inputs") && expected.starts_with("6, the size of"), "{expected}");
}

#[test]
fn inputs_are_a_list_or_a_window() {
    let read = |text: &str| serde_json::from_str::<OnnxInputs>(text);
    assert_eq!(read(r#"["tip"]"#).unwrap(), OnnxInputs::Now(vec![OnnxInput::Tip]));
    let each = vec![OnnxInput::Tip, OnnxInput::Target, OnnxInput::Pulls];
    assert_eq!(read(r#"{"window": 3}"#).unwrap(), OnnxInputs::Past(OnnxWindow { window: 3, each }));
    let error = read(r#"{"windows": 3}"#).unwrap_err().to_string();
    assert!(error.contains("{window: TICKS, each: [tip, …]}"), "{error}");
}
