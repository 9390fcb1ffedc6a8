//! The blind benchmark through the program: the smallest spec end to end, twice the same, failures
//! as rows, and bad keys with their line.

use spinebench::data::findings::{CaseRow, IntervalRow};
use spinebench::data::tables::read_csv;
use std::path::Path;
use std::process::{Command, Output};

const HEAD: &str = "training: {paper: {}}\nseeds: 1\n";
/// A model and a truth on grids that take no time.
const SMALL: &str = "\
model:
  simulated:
    model:
      robot:
        resolution: {cell_m: 0.05, bending_modes: 4, motion_tolerance_m: 0.0005, static_tolerance_m: .inf}
explore: {max_step_m: 0.006}
";

fn run(folder: &Path, text: &str, more: &[&str]) -> Output {
    let experiments = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments");
    let spec = format!("extends: {}/paper.yaml\n{text}", experiments.display());
    std::fs::write(folder.join("blind.yaml"), spec).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_spinebench"));
    command.current_dir(folder).args(["run", "blind.yaml", "--quiet"]).args(more);
    command.env("SPINEBENCH_CACHE", ".spinebench/cache").output().unwrap()
}

const TRUTH: &str =
    "truth: {cell_m: 0.04, bending_modes: 5, time_step_s: 0.1, motion_tolerance_m: 0.0003}";

#[test]
fn the_smallest_spec_runs_end_to_end_and_twice_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let spec = format!(
        "{HEAD}{SMALL}name: blind\nruns:\n  forward: false\n  discovery:\n    {TRUTH}\n    \
         options: {{motion_tolerance_m: 0.0005, most_effects: 1}}\n    \
         oracle: {{outside_above: 1e6, most_effects: 1}}\n    batches:\n      \
         - {{group: nothing, cases: 1, trials: 3, samples: 36}}\n      \
         - {{group: single, cases: 1, trials: 3, samples: 36}}\n      \
         - {{group: outside, cases: 1, trials: 3, samples: 36}}\n"
    );
    let first = run(folder.path(), &spec, &["--out", "one", "--cache", "a", "--jobs", "1"]);
    let said = String::from_utf8_lossy(&first.stderr).into_owned();
    // Nothing is so far outside: that case fails, and says so in its row.
    assert_eq!(first.status.code(), Some(1), "{said}");
    assert!(said.contains("1 stages failed, the first is blind_truth"), "{said}");
    let table = folder.path().join("one/results/blind/discovery.csv");
    let rows: Vec<CaseRow> = read_csv(&table).unwrap();
    let heads: Vec<(u64, &str, &str)> =
        rows.iter().map(|row| (row.case, row.group.as_str(), row.truth.as_str())).collect();
    assert_eq!(heads, [(0, "nothing", ""), (1, "single", "tip_load"), (2, "outside", "")]);
    assert!(
        ["consistent", "named", "ambiguous", "unexplained"].contains(&rows[0].verdict.as_str()),
        "{:?}",
        rows[0]
    );
    assert!(
        rows[1].shift_m > 0.0035 && rows[1].before_m > 0.002 && rows[1].after_m <= rows[1].before_m,
        "{:?}",
        rows[1]
    );
    assert!(
        rows[2].verdict.starts_with("failed: blind_truth: none of 10 candidates"),
        "{:?}",
        rows[2]
    );
    let intervals: Vec<IntervalRow> = read_csv(&table.with_file_name("intervals.csv")).unwrap();
    for row in &rows {
        let own: Vec<&IntervalRow> =
            intervals.iter().filter(|interval| interval.case == row.case).collect();
        let covered = own.iter().filter(|interval| interval.covered).count();
        assert_eq!((row.intervals, row.covered), (own.len() as u64, covered as u64), "{row:?}");
        assert!(
            own.iter().all(|one| one.covered == (one.low..=one.high).contains(&one.truth)),
            "{own:?}"
        );
    }
    let again = run(folder.path(), &spec, &["--out", "two", "--cache", "b", "--jobs", "2"]);
    assert_eq!(again.status.code(), Some(1));
    let bytes = |out: &str| {
        std::fs::read(folder.path().join(out).join("results/blind/discovery.csv")).unwrap()
    };
    assert_eq!(bytes("one"), bytes("two"), "the number of threads changes nothing");
}

/// What stands below `discovery:` (which is line 4), and how the error begins after `error: `.
const BAD: &[(&str, &str)] = &[
    (
        "batches: []",
        "blind.yaml:5:14: runs.discovery.batches: found an empty list, expected at least one batch",
    ),
    ("batchs: []", "blind.yaml:5:5: runs.discovery.batchs: found the unknown key `batchs`"),
    (
        "batches:\n      - {group: singel, cases: 3}",
        "blind.yaml:6:17: runs.discovery.batches[0].group: found the unknown name `singel`",
    ),
    (
        "batches:\n      - {group: single, cases: 0}",
        "blind.yaml:6:32: runs.discovery.batches[0].cases: found 0, expected 1 to 100000",
    ),
    (
        "batches:\n      - {group: single, cases: 1, shifts_m: [4]}",
        "blind.yaml:6:45: runs.discovery.batches[0].shifts_m: found 4, expected above 0 and up to \
         0.05 m",
    ),
    (
        "batches:\n      - {group: single, cases: 1, shifts_mm: [4]}",
        "blind.yaml:6:35: runs.discovery.batches[0].shifts_mm: found the unknown key `shifts_mm`",
    ),
    (
        "batches:\n      - {group: nothing, cases: 1, correlations: [0, 1]}",
        "blind.yaml:6:50: runs.discovery.batches[0].correlations: found 1, expected 0 to below 1",
    ),
    (
        "batches:\n      - {group: nothing, cases: 1, noise_m: 0.5}",
        "blind.yaml:6:45: runs.discovery.batches[0].noise_m: found 0.5, expected above 0 and up to \
         0.05 m",
    ),
    (
        "batches:\n      - {group: nothing, cases: 1, trials: 30, samples: 40}",
        "blind.yaml:6:44: runs.discovery.batches[0].trials: found 30, expected at least 2, and 2 \
         samples in each",
    ),
    (
        "options: {held_out_share: 1.5}\n    batches: [{group: nothing, cases: 1}]",
        "blind.yaml:5:31: runs.discovery.options.held_out_share: found 1.5, expected a number \
         between 0 and 1",
    ),
    (
        "options: {left_out: [tip_lode]}\n    batches: [{group: nothing, cases: 1}]",
        "blind.yaml:5:26: runs.discovery.options.left_out[0]: found `tip_lode`, expected one of",
    ),
    (
        "options: {uncertain: [{effect: tip_load, parameter: mass_g, deviation: 1}]}\n    batches: \
         [{group: nothing, cases: 1}]",
        "blind.yaml:5:57: runs.discovery.options.uncertain[0].parameter: found `mass_g`, expected \
         `mass_kg`",
    ),
    (
        "truth: {cell_m: 0}\n    batches: [{group: nothing, cases: 1}]",
        "blind.yaml:5:21: runs.discovery.truth.cell_m: found 0, expected a finite number above 0",
    ),
    (
        "oracle: {outside_above: 0.1}\n    batches: [{group: nothing, cases: 1}]",
        "blind.yaml:5:29: runs.discovery.oracle.outside_above: found 0.1, expected at least \
         inside_below",
    ),
];

#[test]
fn bad_keys_are_named_with_their_line() {
    let folder = tempfile::tempdir().unwrap();
    for (text, expected) in BAD {
        let spec = format!("runs:\n  forward: false\n  discovery:\n    {text}\n");
        let out = run(folder.path(), &spec, &["--out", "out"]);
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        let said = said.trim_start_matches("error: ");
        assert!(said.starts_with(expected), "{text}\n  gave   {said}\n  wanted {expected}");
        assert_eq!(out.status.code(), Some(2), "{text}");
        assert!(!folder.path().join("out").exists(), "{text}");
    }
}
