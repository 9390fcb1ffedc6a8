//! What editors and shells get: JSON Schema of the files, and completions.

use crate::support::schema_check::problems;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn spinebench(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_spinebench")).args(arguments).output().unwrap()
}

fn schema(kind: &str) -> Value {
    let output = spinebench(&["schema", kind]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn yaml(text: &str) -> Value {
    serde_yaml::from_str(text).unwrap()
}

/// YAML files directly in a folder of this repository.
fn files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().flatten().map(|file| file.path()).collect();
    files.retain(|file| file.extension().is_some_and(|end| end == "yaml"));
    assert!(!files.is_empty());
    files
}

#[test]
fn every_shipped_file_is_what_its_schema_says() {
    let cases = [
        ("experiment", vec!["experiments", "experiments/sweeps"]),
        ("model", vec!["models"]),
        ("plant", vec!["experiments/plants"]),
    ];
    for (kind, folders) in cases {
        let schema = schema(kind);
        for file in folders.iter().flat_map(|folder| files(folder)) {
            let found = problems(&schema, &yaml(&std::fs::read_to_string(&file).unwrap()));
            assert!(found.is_empty(), "{}: {found:?}", file.display());
        }
    }
}

#[test]
fn what_is_resolved_needs_nothing_that_it_extends_and_is_valid_too() {
    let schema = schema("experiment");
    for name in ["smoke.yaml", "discovery.yaml", "table1.yaml"] {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments").join(name);
        let experiment = spinebench::specs::Experiment::read(&file, &[]).unwrap();
        let found = problems(&schema, &yaml(&spinebench::specs::to_yaml(&experiment).unwrap()));
        assert!(found.is_empty(), "{name}: {found:?}");
    }
}

#[test]
fn what_the_program_refuses_by_its_keys_the_schema_refuses() {
    let cases = [
        ("experiment", "{extends: smoke.yaml, seedz: 3}"),
        ("experiment", "{extends: smoke.yaml, gp: {kernle: se_ard}}"),
        ("experiment", "{extends: smoke.yaml, gp: {kernel: se_adr}}"),
        ("experiment", "{extends: smoke.yaml, gp: {kernel: se_ard + foo}}"),
        ("experiment", "{extends: smoke.yaml, gp: {starts: many}}"),
        ("experiment", "{extends: smoke.yaml, modes: {closed: {feedback: ajar}}}"),
        (
            "experiment",
            "{extends: smoke.yaml, modes: {closed: {effects: [{tip_lode: {mass_kg: 1}}]}}}",
        ),
        ("experiment", "{extends: smoke.yaml, modes: {closed: {effects: [{tip_load: {}}]}}}"),
        ("experiment", "{extends: smoke.yaml, runs: {reach: [{policies: [a]}]}}"),
        ("experiment", "{extends: smoke.yaml, plant: {hologram: {}}}"),
        ("experiment", "{extends: smoke.yaml, policies: {mine: {file: mine.onnx}}}"),
        ("experiment", "{extends: smoke.yaml, policies: {mine: {onnx: {flie: mine.onnx}}}}"),
        ("experiment", "{extends: smoke.yaml, sweep: {gp.kernel: se_ard}}"),
        ("experiment", "{extends: smoke.yaml, sweep: {gp.starts: {range: {from: 1, too: 2}}}}"),
        ("experiment", "{extends: smoke.yaml, sweep: {gp.starts: []}}"),
        ("experiment", "{name: alone}"),
        ("model", "{robot: {backbone: {length: 1}}}"),
        ("model", "{effects: []}"),
        ("plant", "{simulated: {noise_m: 0.001}}"),
        ("map", "{commands: {tendons: {columns: [0]}}}"),
        ("map", "{commands: {tendons: {columns: [a], unit: furlong}}}"),
    ];
    for (kind, text) in cases {
        assert!(!problems(&schema(kind), &yaml(text)).is_empty(), "{kind}: {text}");
    }
    let good = [
        (
            "experiment",
            "{extends: smoke.yaml, gp: {kernel: '(se + linear[place]) * periodic[1-2, 4] + \
             white'}}",
        ),
        ("experiment", "{extends: smoke.yaml, plant: {simulated: {noise_m: 0.001}}}"),
        ("experiment", "{extends: smoke.yaml, model: {simulated: {model: ../models/real.yaml}}}"),
        (
            "experiment",
            "{extends: smoke.yaml, policies: {mine: {onnx: {file: mine.onnx}}, c: {max_switches: \
             3}}}",
        ),
        (
            "experiment",
            "{extends: smoke.yaml, policies: {mine: {python: {file: mine.py, class: Mine}}}}",
        ),
        (
            "experiment",
            "{extends: smoke.yaml, policies: {outside: {mine: {onnx: {file: mine.onnx}}}}}",
        ),
        (
            "experiment",
            "{extends: smoke.yaml, sweep: {gp.kernel: [matern52], gp.starts: null, seed: {random: \
             {from: 1, to: 9, count: 3, whole: true}}}}",
        ),
        ("plant", "{simulated: {model: ../models/real.yaml}}"),
        (
            "map",
            "{commands: {tendons: {columns: [a, 2]}}, tracking: {tip: {position: [1, y, z]}, \
             clock: {estimate: {}}}}",
        ),
        ("map", "{commands: {tendons: {columns: [a]}}, tracking: {tip: {}, clock: same}}"),
    ];
    for (kind, text) in good {
        let found = problems(&schema(kind), &yaml(text));
        assert!(found.is_empty(), "{kind}: {text}: {found:?}");
    }
}

#[test]
fn the_whole_catalogue_is_in_the_schema_with_words_for_every_key() {
    let schema = schema("model");
    let text = schema.to_string();
    for card in spinebench::effects::CATALOGUE {
        assert!(text.contains(&format!("\"{}\"", card.name)), "{}", card.name);
        for parameter in card.parameters {
            let name = parameter.name.split('[').next().unwrap();
            assert!(text.contains(&format!("\"{name}\"")), "{}.{name}", card.name);
        }
    }
    let robot = &schema["$defs"]["Robot"]["properties"];
    assert_eq!(
        robot["damping_time_s"]["description"],
        "Bending damping over bending stiffness, s."
    );
}

/// The checker itself: it must find what is wrong and refuse what it does not know.
#[test]
fn the_checker_checks() {
    let schema = json!({
        "type": "object", "properties": {"a": {"type": "integer", "minimum": 0}, "b": {"$ref": "#/$defs/B"}},
        "required": ["a"], "additionalProperties": false,
        "$defs": {"B": {"oneOf": [{"const": "x"}, {"type": "array", "items": {"enum": [1, 2]}, "minItems": 1}]}},
    });
    for good in [json!({"a": 1}), json!({"a": 0, "b": "x"}), json!({"a": 0, "b": [1, 2]})] {
        assert_eq!(problems(&schema, &good), [] as [String; 0], "{good}");
    }
    for bad in [
        json!({}),
        json!({"a": -1}),
        json!({"a": 1.5}),
        json!({"a": 1, "c": 1}),
        json!({"a": 1, "b": []}),
        json!({"a": 1, "b": [3]}),
    ] {
        assert!(!problems(&schema, &bad).is_empty(), "{bad}");
    }
    assert!(
        std::panic::catch_unwind(|| problems(&json!({"patternProperties": {}}), &json!({})))
            .is_err()
    );
}

#[test]
fn completions_are_scripts_that_know_the_commands() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let output = spinebench(&["completions", shell]);
        assert!(output.status.success(), "{shell}");
        let script = String::from_utf8(output.stdout).unwrap();
        for word in ["discover", "schema", "sweep"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
        if !["bash", "zsh", "fish"].contains(&shell) {
            continue;
        }
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("script");
        std::fs::write(&file, script).unwrap();
        match Command::new(shell).arg("-n").arg(&file).output() {
            Ok(output) => assert!(
                output.status.success(),
                "{shell}: {}",
                String::from_utf8_lossy(&output.stderr)
            ),
            Err(error) => eprintln!("{shell} -n skipped: {error}"),
        }
    }
    assert_eq!(spinebench(&["completions", "cmd"]).status.code(), Some(2));
    assert_eq!(spinebench(&["schema", "poem"]).status.code(), Some(2));
}
