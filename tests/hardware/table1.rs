//! Table I, small, on a rehearsed bench: the whole closed loop through the drivers of the motors
//! and the tracker.

use std::collections::BTreeSet;
use std::process::Command;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

fn spec() -> String {
    format!(
        "extends: {ROOT}/experiments/smoke.yaml
name: bench
seeds: 1
plant:
  hardware:
    name: table1
    model: {ROOT}/models/nominal.yaml
    settle_s: 1.0
    rehearsal: {{model: {ROOT}/models/real.yaml, noise_m: 0.0005, loss: 0.01}}
targets: {{sweep: {{rows: 5, columns: 5, max_pull_m: 0.012, max_step_m: 0.003}}}}
runs:
  reach:
    - {{policies: [a, b, c, pi_real], modes: [open, closed, closed_load], gp_points: [20], real_points: [200]}}
claims: []
"
    )
}

fn column(table: &str, name: &str) -> Vec<String> {
    let mut lines = table.lines();
    let index = lines.next().unwrap().split(',').position(|cell| cell == name).unwrap();
    lines.map(|line| line.split(',').nth(index).unwrap().to_owned()).collect()
}

#[test]
fn the_closed_loop_runs_through_the_drivers() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bench.yaml"), spec()).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_spinebench"))
        .current_dir(folder.path())
        .args(["run", "bench.yaml", "--threads", "2"])
        .env("SPINEBENCH_CACHE", ".spinebench/cache")
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{said}");
    let table = std::fs::read_to_string(folder.path().join("results/bench/trials.csv")).unwrap();
    let status = column(&table, "status");
    // Policy C needs to see the tip: it has no open loop.
    let conditions: BTreeSet<(String, String)> =
        column(&table, "policy").into_iter().zip(column(&table, "mode")).collect();
    assert_eq!((conditions.len(), status.len() % conditions.len()), (11, 0), "{table}");
    assert!(status.iter().all(|status| status == "ok"), "{table}");
    // Barely trained networks reach nothing well; that they move the tip by centimetres and not out
    // of the world is the loop's.
    let errors: Vec<f64> =
        column(&table, "error_m").iter().map(|cell| cell.parse().unwrap()).collect();
    assert!(errors.iter().all(|error_m| *error_m < 0.2), "{errors:?}");
    assert!(folder.path().join("plots").is_dir(), "{said}");
}
