//! Policies from outside in a spec: rows and a line of the table like any other, stored under the
//! content of their file.

use std::path::Path;
use std::process::{Command, Output};

const TORCH: &[u8] = include_bytes!("../data/onnx/torch_policy.onnx");

fn spec(policies: &str) -> String {
    format!(
        "name: mine\ncontrol_hz: 5\nmodel: {{constant_curvature: {{}}}}\nplant: \
         {{constant_curvature: {{}}}}\ntraining: {{paper: {{}}}}\ntargets: {{pool: 30, drawn: 3, \
         sweep: {{rows: 7, columns: 7}}}}\nmodes: {{open: {{feedback: open}}, closed: {{feedback: \
         closed}}}}\nreach: {{max_steps: 20}}\npolicies:\n{policies}\nruns:\n  reach:\n    - \
         {{policies: [mine], modes: [open, closed]}}\nfigures: [table1]\n"
    )
}

fn run(folder: &Path, policies: &str) -> Output {
    std::fs::write(folder.join("mine.yaml"), spec(policies)).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_spinebench"));
    command
        .current_dir(folder)
        .args(["run", "mine.yaml"])
        .env("SPINEBENCH_CACHE", ".spinebench/cache")
        .output()
        .unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Number of stages that a run has computed.
fn computed(output: &Output) -> usize {
    let said = said(output);
    let line = said.lines().find(|line| line.contains("stages computed")).unwrap();
    line.split(' ').find_map(|word| word.parse().ok()).unwrap()
}

#[test]
fn a_network_of_a_file_has_rows_a_line_in_the_table_and_a_place_in_the_store() {
    let folder = tempfile::tempdir().unwrap();
    let network = folder.path().join("net.onnx");
    std::fs::write(&network, TORCH).unwrap();
    let policies = "  mine: {onnx: {file: net.onnx, position_scale_m: 0.2, pull_scale_m: 0.02}}";
    let first = run(folder.path(), policies);
    assert!(first.status.success(), "{}", said(&first));
    let read = |name: &str| {
        std::fs::read_to_string(folder.path().join("results/mine").join(name)).unwrap()
    };
    let trials = read("trials.csv");
    let rows: Vec<&str> = trials.lines().filter(|line| line.contains(",mine,")).collect();
    assert_eq!(rows.len(), 6, "{trials}");
    assert!(rows.iter().all(|row| row.ends_with(",ok")), "{trials}");
    assert!(read("table1.md").contains("mine"), "{}", read("table1.md"));
    // The resolved spec runs from another folder.
    assert!(read("spec.yaml").contains(&folder.path().join("net.onnx").display().to_string()));
    assert_eq!(computed(&run(folder.path(), policies)), 0, "nothing has changed");
    // Another content under the same name is another policy; the targets are the same.
    let mut other = TORCH.to_vec();
    let place = other.windows(8).rposition(|window| window == b"0.weight").unwrap() + 20;
    other[place] ^= 0x01;
    std::fs::write(&network, other).unwrap();
    assert_eq!(computed(&run(folder.path(), policies)), 2, "two sets of trials");
}

#[test]
fn faults_name_the_line_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("net.onnx"), TORCH).unwrap();
    for (policies, words) in [
        ("  mine: {onnx: {file: none.onnx}}", "none.onnx"),
        ("  mine: {onnx: {file: mine.yaml}}", "not an ONNX model"),
        ("  mine: {onnx: {file: net.onnx, inputs: [tip]}}", "10 inputs, expected 3"),
        ("  mine: {onnx: {file: net.onnx, scale: 2}}", "scale"),
        ("  mine: {onnx: {file: net.onnx, settled_m: -1}}", "settled_m"),
        // No policy of Python, or no Python at all.
        ("  mine: {python: {file: mine.yaml, class: Mine}}", "a class that can be loaded"),
    ] {
        let output = run(folder.path(), policies);
        let said = said(&output);
        assert_eq!(output.status.code(), Some(2), "{policies}: {said}");
        assert!(said.contains("mine.yaml:1") && said.contains(words), "{policies}: {said}");
        assert!(!folder.path().join("results").exists(), "{policies}");
    }
}
