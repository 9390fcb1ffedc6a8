//! Populations: every repetition has a robot of its own, and the tables say what holds on how many.

use spinebench::report::{Published, published_rows};
use spinebench::specs::{ExperimentSet, read_model};
use std::path::{Path, PathBuf};
use std::process::Command;

fn experiments() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments")
}

#[test]
fn the_shipped_population_draws_the_same_robots_and_more_of_them_begin_alike() {
    let read = |sets: &[&str]| {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
        ExperimentSet::read(&experiments().join("population.yaml"), &sets, &[]).unwrap().experiment
    };
    let (all, few) = (read(&[]), read(&["seeds=3"]));
    assert_eq!(all.seeds, 100);
    let nominal = read_model(&experiments().join("../models/nominal.yaml")).unwrap();
    assert!(nominal.effects.is_empty(), "the model that they are drawn around");
    assert_eq!(all.drawn_effects(2), few.drawn_effects(2));
    assert_ne!(all.drawn_effects(2), read(&["seed=2"]).drawn_effects(2));
    assert!((0..100).all(|seed| (1..=5).contains(&all.drawn_effects(seed).len())));
    assert!(read(&["population=null"]).drawn_effects(2).is_empty());
}

#[test]
fn a_population_is_run_and_published_with_what_holds_on_how_many_robots() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!(
        "extends: {}/smoke.yaml\nname: few\nplant: {{simulated: {{model: \
         {0}/../models/nominal.yaml}}}}\npopulation: {{least_effects: 2, most_effects: 2, effects: \
         [tip_load, base_tilt, bending_stiffness]}}\ntraining: {{paper: null, converged: \
         {{}}}}\nfigures: [population]\nruns: {{gap: null, forward: false, gp_points: [], reach: \
         [{{policies: [a, pi_real], modes: [closed], gp_points: [20], real_points: [200]}}], \
         track: null}}\nclaims:\n- claim: a_beats_pi_real\n  statement: A outperforms pi_real\n  \
         relation: {{less: {{left: {{reach_mean: {{policy: a, mode: closed}}}}, right: \
         {{reach_mean: {{policy: pi_real, mode: closed}}}}}}}}\n",
        experiments().display()
    );
    std::fs::write(folder.path().join("few.yaml"), text).unwrap();
    let spinebench = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_spinebench"));
        let output = command
            .current_dir(folder.path())
            .args(arguments)
            .env("SPINEBENCH_CACHE", ".spinebench/cache")
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{arguments:?}: {said}");
        said
    };
    spinebench(&["run", "few.yaml", "--seeds", "8", "--quiet"]);
    let results = folder.path().join("results/few");
    let published = Published::read(&results).unwrap();
    let mut robots: Vec<(u64, &str)> =
        published.robots.iter().map(|row| (row.seed, row.effect.as_str())).collect();
    robots.dedup();
    assert_eq!(robots.len(), 8 * 2, "{robots:?}");
    let claim = &published.robot_claims[0];
    // The share is that of the repetitions in which the means say so.
    let mean = |seed: u64, policy: &str| {
        let errors: Vec<f64> = published
            .trials
            .iter()
            .filter(|row| row.seed == seed && row.cell.policy == policy)
            .map(|row| row.error_m)
            .collect();
        errors.iter().sum::<f64>() / errors.len() as f64
    };
    let held = (0..8).filter(|&seed| mean(seed, "a") < mean(seed, "pi_real")).count() as u64;
    assert_eq!((claim.robots, claim.held), (8, held));
    assert!(
        (claim.share - held as f64 / 8.0).abs() < 1e-8
            && claim.low_95 < claim.share
            && claim.share < claim.high_95
    );
    for name in ["population.csv", "attribution.csv", "population.md"] {
        assert!(results.join(name).is_file(), "{name}");
    }
    assert!(folder.path().join("plots/few/population.png").is_file());
    assert!(
        results.join("claims.csv").is_file() && !folder.path().join("results/claims.csv").exists(),
        "not the paper's"
    );
    // Each robot has trials of its own, and the whole is repeated from the published spec.
    let first: Vec<f64> =
        published.trials.iter().filter(|row| row.target == 0).map(|row| row.error_m).collect();
    assert!(first.windows(2).all(|pair| pair[0] != pair[1]), "{first:?}");
    spinebench(&["verify", "few", "--quiet"]);
    let effects: Vec<spinebench::rows::population::AttributionRow> =
        published_rows(&results).unwrap();
    assert!(effects.iter().all(|row| row.robots_with + row.robots_without == 8), "{effects:?}");
}
