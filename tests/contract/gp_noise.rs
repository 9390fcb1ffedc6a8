//! The noise of a Gaussian process on few points: with the likelihood alone it falls to the end of
//! its range now and then, which is told; with the tracker's noise as a prior it does not.

use std::path::Path;
use std::process::Command;

/// Tracking noise of the smoke experiment's robot, metres.
const NOISE_M: f64 = 5e-4;

/// What a run of one repetition published and said.
struct FewPoints {
    noise_y_m: f64,
    at_range_end: String,
    covered_y: f64,
    said: String,
}

/// Runs repetition `seed` of a Gaussian process on `points` points.
fn fit(seed: u64, points: u64, prior: &str) -> FewPoints {
    let folder = tempfile::tempdir().unwrap();
    let experiments = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments");
    let spec = format!(
        "extends: {}/smoke.yaml\nname: few\nseeds: 1\nfirst_seed: {seed}\nfigures: null\nclaims: \
         null\ngp: {{noise_prior: {prior}}}\nruns: {{gap: null, forward: null, reach: null, track: \
         null, gp_points: [{points}], gp_coverage: [0.95]}}\n",
        experiments.display()
    );
    std::fs::write(folder.path().join("few.yaml"), spec).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_spinebench"));
    command.current_dir(folder.path()).args(["run", "few.yaml", "--out", "out", "--quiet"]);
    let output = command.env("SPINEBENCH_CACHE", ".spinebench/cache").output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{said}");
    let rows = |file: &str| -> Vec<Vec<(String, String)>> {
        let text =
            std::fs::read_to_string(folder.path().join("out/results/few").join(file)).unwrap();
        let names: Vec<&str> = text.lines().next().unwrap().split(',').collect();
        let row = |line: &str| {
            let cells = line.split(',').map(str::to_owned);
            names.iter().map(|name| (*name).to_owned()).zip(cells).collect()
        };
        text.lines().skip(1).map(row).collect()
    };
    let cell = |row: &[(String, String)], name: &str| {
        row.iter().find(|(column, _)| column == name).unwrap().1.clone()
    };
    let gp = &rows("gp.csv")[0];
    let coverage = rows("gp_coverage.csv");
    let of_y = coverage.iter().find(|row| cell(row, "axis") == "y").unwrap();
    FewPoints {
        noise_y_m: cell(gp, "noise_y_m").parse().unwrap(),
        at_range_end: cell(gp, "at_range_end"),
        covered_y: cell(of_y, "covered").parse().unwrap(),
        said,
    }
}

#[test]
fn noise_at_the_end_of_its_range_is_told() {
    for (seed, points) in [(0, 40), (5, 40)] {
        let FewPoints { noise_y_m, at_range_end, covered_y, said } = fit(seed, points, "null");
        assert!(noise_y_m < 0.01 * NOISE_M && covered_y < 0.75, "{noise_y_m} {covered_y}");
        assert!(at_range_end.contains("y noise variance low"), "{at_range_end}");
        assert!(
            said.contains("noise variance low: 1") && said.contains("gp: {noise_prior: {}}"),
            "{said}"
        );
    }
}

#[test]
fn with_the_noise_of_the_tracker_as_a_prior_it_stays_there() {
    for (seed, points) in [(0, 40), (5, 40), (106, 40), (109, 30)] {
        let FewPoints { noise_y_m, at_range_end, covered_y, said } = fit(seed, points, "{}");
        assert!((0.6..1.8).contains(&(noise_y_m / NOISE_M)), "{noise_y_m}");
        assert!(!at_range_end.contains("noise"), "{at_range_end}");
        assert!(covered_y > 0.7, "seed {seed}: {covered_y}");
        assert!(!said.contains("noise variance low"), "{said}");
    }
}
