//! Bad settings of Gaussian processes and of what uses them: one error with file, line, column,
//! key, what was found and what was expected.

use std::path::Path;
use std::process::Command;

/// The text after `extends:` (which is line 1), and how the error begins after `error: `.
const BAD: &[(&str, &str)] = &[
    (
        "gp: {approximation: vfe}",
        "bad.yaml:2:21: gp.approximation: found the unknown name `vfe`, expected",
    ),
    ("gp: {mean: cubic}", "bad.yaml:2:12: gp.mean: found the unknown name `cubic`, expected"),
    ("gp: {inducing_points: 1}", "bad.yaml:2:23: gp.inducing_points: found 1, expected 2 to 2000"),
    (
        "gp: {mean: linear}\nruns: {gp_points: [9]}",
        "bad.yaml:3:20: runs.gp_points[0]: found 9, expected 10 to 80",
    ),
    (
        "gp_points: {layout: {grid: {rows: 80, columns: 80, max_pull_m: 0.02}}}\nruns: {gp_points: \
         [10, 5001]}",
        "bad.yaml:3:24: runs.gp_points[1]: found 5001, expected at most 5000 points for an exact \
         process; `gp.approx",
    ),
    (
        "runs: {gp_points: [20], gp_leave_one_out: [0]}",
        "bad.yaml:2:44: runs.gp_leave_one_out[0]: found 0, expected a share",
    ),
    (
        "policies: {a_online: {points: 0}}",
        "bad.yaml:2:31: policies.a_online.points: found 0, expected a whole number",
    ),
    (
        "policies: {a_online: {most_m: 0}}",
        "bad.yaml:2:31: policies.a_online.most_m: found 0, expected a finite number above 0",
    ),
    (
        "policies: {a_online: {leaves: newest}}",
        "bad.yaml:2:31: policies.a_online.leaves: found the unknown name `newest`, expected",
    ),
    (
        "gp: {noise_prior: {std_m: -1}}",
        "bad.yaml:2:27: gp.noise_prior.std_m: found -1, expected 0 or more",
    ),
];

#[test]
fn bad_settings_of_processes_are_refused_with_their_place() {
    let experiments = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments");
    for (text, expected) in BAD {
        let folder = tempfile::tempdir().unwrap();
        let spec = format!("extends: {}/smoke.yaml\n{text}", experiments.display());
        std::fs::write(folder.path().join("bad.yaml"), spec).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_spinebench"));
        command.current_dir(folder.path()).args(["run", "bad.yaml", "--out", "out", "--quiet"]);
        let output = command.env("SPINEBENCH_CACHE", ".spinebench/cache").output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{text}\n{said}");
        assert!(
            said.starts_with(&format!("error: {expected}")),
            "{text}\n  said   {said}  wanted error: {expected}"
        );
        assert!(said.lines().count() == 1 && !folder.path().join("out").exists(), "{text}\n{said}");
    }
}
