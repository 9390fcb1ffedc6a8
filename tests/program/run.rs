//! The commands `run`, `plan` and `verify` at smoke size: same bytes on any number of threads,
//! nothing computed twice.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const SMOKE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/experiments/smoke.yaml");

fn spinebench(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_spinebench"));
    command
        .current_dir(folder)
        .args(arguments)
        .env("SPINEBENCH_CACHE", ".spinebench/cache")
        .output()
        .unwrap()
}

/// Runs and returns the summary's counts: stages computed and read.
fn run(folder: &Path, arguments: &[&str]) -> (usize, usize) {
    let output = spinebench(folder, &[&["run"], arguments].concat());
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{said}");
    let line = said.lines().find(|line| line.contains("stages computed")).unwrap();
    let numbers: Vec<usize> = line.split(' ').filter_map(|word| word.parse().ok()).collect();
    (numbers[0], numbers[1])
}

/// All files below a folder, entries of the store included, except those that hold clocks.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    fn visit(root: &Path, folder: &Path, found: &mut BTreeMap<PathBuf, Vec<u8>>) {
        for entry in std::fs::read_dir(folder).unwrap().flatten() {
            let path = entry.path();
            if path.is_dir() {
                visit(root, &path, found);
            } else if !["manifest.yaml", "stages.csv"].iter().any(|name| path.ends_with(name))
                && path.extension().is_none_or(|end| end != "note")
            {
                found.insert(
                    path.strip_prefix(root).unwrap().to_owned(),
                    std::fs::read(&path).unwrap(),
                );
            }
        }
    }
    let mut found = BTreeMap::new();
    visit(folder, folder, &mut found);
    found
}

#[test]
fn one_two_and_eight_threads_give_the_same_bytes_and_verify_agrees() {
    let folder = tempfile::tempdir().unwrap();
    let mut results = Vec::new();
    for threads in ["1", "2", "8"] {
        let (out, cache) = (format!("out{threads}"), format!("cache{threads}"));
        let (computed, cached) = run(
            folder.path(),
            &[SMOKE, "--threads", threads, "--out", &out, "--cache", &cache, "--seeds", "1"],
        );
        assert!(computed > 30 && cached == 0, "{computed} computed, {cached} read");
        results.push(files(&folder.path().join(out)));
    }
    for name in
        ["trials.csv", "tracks.csv", "networks.csv", "gp.csv", "gap.csv", "claims.csv", "spec.yaml"]
    {
        assert!(results[0].contains_key(&Path::new("results/smoke").join(name)), "{name}");
    }
    assert!(results[0].keys().any(|path| path.ends_with("table1.png")), "{:?}", results[0].keys());
    assert!(
        results[0] == results[1] && results[0] == results[2],
        "results depend on the number of threads"
    );

    // Tables in Parquet are as good as those in CSV, and come back as they were.
    let trials = folder.path().join("out1/results/smoke/trials.csv");
    let [csv, parquet] = ["csv", "parquet"].map(|end| {
        ["trials", "tracks", "gap", "claims"]
            .map(|table| format!("out1/results/smoke/{table}.{end}"))
    });
    let pack = |arguments: &[&str], tables: &[String]| {
        let tables = tables.iter().map(String::as_str);
        let output = spinebench(
            folder.path(),
            &[&["pack"], arguments, &tables.collect::<Vec<_>>()].concat(),
        );
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    assert_eq!(pack(&[], &csv), (Some(0), String::new()));
    assert!(!trials.exists() && trials.with_extension("parquet").is_file());
    let verified = spinebench(folder.path(), &["verify", "--out", "out1", "--quiet"]);
    assert_eq!(verified.status.code(), Some(0), "{}", String::from_utf8_lossy(&verified.stderr));
    let again = spinebench(folder.path(), &["gather", "out1/results/smoke", "--out", "gathered"]);
    assert_eq!(again.status.code(), Some(0), "{}", String::from_utf8_lossy(&again.stderr));
    assert_eq!(pack(&["--undo"], &parquet), (Some(0), String::new()));
    assert!(files(&folder.path().join("out1")) == results[0], "a packed table came back changed");
    assert!(
        files(&folder.path().join("gathered")) == results[0],
        "what is drawn from packed tables differs"
    );
    assert!(pack(&[], &parquet).1.contains("trials.parquet"), "what is not there is named");

    // A changed row, and another result of an early stage: the trail names it.
    let text = std::fs::read_to_string(&trials).unwrap();
    std::fs::write(&trials, text.replacen(",true,", ",false,", 1)).unwrap();
    let trail = folder.path().join("out1/results/smoke/stages.csv");
    let text = std::fs::read_to_string(&trail).unwrap();
    let row = text.lines().find(|line| line.starts_with("gp_fit,")).unwrap();
    let mut cells: Vec<&str> = row.split(',').collect();
    let at = cells.len() - 3;
    cells[at] = "0123456789ab";
    std::fs::write(&trail, text.replacen(row, &cells.join(","), 1)).unwrap();
    let differs = spinebench(folder.path(), &["verify", "--out", "out1", "--quiet"]);
    assert_eq!(differs.status.code(), Some(1));
    let said = String::from_utf8(differs.stderr).unwrap();
    assert!(said.starts_with("error: smoke: differs: reach: results/smoke/trials.csv:"), "{said}");
    assert!(said.contains("; first stage that differs: gp_fit (Gaussian process"), "{said}");
    assert!(said.contains("published 0123456789ab, found "), "{said}");
}

#[test]
fn nothing_is_computed_twice_and_damage_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [SMOKE, "--seeds", "1"];
    let (computed, _) = run(folder.path(), &arguments);
    let before = files(folder.path());
    let (again, cached) = run(folder.path(), &arguments);
    assert!(again == 0 && cached > 0 && cached <= computed, "{again} computed, {cached} read");
    assert!(files(folder.path()) == before, "a run from the store gives other results");

    // One entry truncated, one with a flipped bit: both are computed again, and nothing else is.
    let reach: Vec<PathBuf> =
        before.keys().filter(|path| path.starts_with(".spinebench/cache/reach")).cloned().collect();
    let good = &before[&reach[0]];
    std::fs::write(folder.path().join(&reach[0]), &good[..good.len() / 2]).unwrap();
    let mut flipped = before[&reach[1]].clone();
    let last = flipped.len() - 1;
    flipped[last] ^= 1;
    std::fs::write(folder.path().join(&reach[1]), flipped).unwrap();
    let output = spinebench(folder.path(), &[&["run"], &arguments[..]].concat());
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(said.matches("is damaged").count(), 2, "{said}");
    assert!(said.contains("\n2 stages computed") || said.contains("2 stages computed"), "{said}");
    assert!(files(folder.path()) == before, "what was damaged did not come back as it was");

    // A changed setting leaves alone what does not depend on it.
    let (changed, _) =
        run(folder.path(), &[SMOKE, "--seeds", "1", "--set", "policies.c.switch_threshold_m=0.01"]);
    assert_eq!(
        changed,
        22 + 8,
        "reaching and tracking depend on the policies' settings, and nothing else"
    );
    let (more, _) = run(folder.path(), &[SMOKE, "--seeds", "2"]);
    assert!(more < computed, "the first seed is not computed again");
}

#[test]
#[expect(clippy::too_many_lines, reason = "one story")]
fn repetitions_run_apart_are_gathered_into_what_they_are_together() {
    let folder = tempfile::tempdir().unwrap();
    let part = |seeds: &str, first: &str, out: &str| {
        let first = format!("first_seed={first}");
        let arguments =
            [SMOKE, "--seeds", seeds, "--set", &first, "--out", out, "--cache", "cache"];
        run(folder.path(), &arguments)
    };
    let (together, _) = part("2", "0", "together");
    assert!(together > 0);
    for (first, out) in [("0", "first"), ("1", "second"), ("2", "third")] {
        let (computed, _) = part("1", first, out);
        assert_eq!(
            computed > 0,
            first == "2",
            "what a repetition is depends on where a run begins"
        );
    }
    let gather = |arguments: &[&str]| {
        let output = spinebench(folder.path(), &[&["gather"], arguments].concat());
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let (first, second, third) =
        ("first/results/smoke", "second/results/smoke", "third/results/smoke");
    assert_eq!(gather(&[second, first, "--out", "joined"]), (Some(0), String::new()));
    let [whole, joined] = ["together", "joined"].map(|out| files(&folder.path().join(out)));
    assert_eq!(whole.keys().collect::<Vec<_>>(), joined.keys().collect::<Vec<_>>());
    for (name, bytes) in &whole {
        assert!(joined[name] == *bytes, "{} differs", name.display());
    }
    let stages = |out: &str| {
        std::fs::read_to_string(folder.path().join(out).join("results/smoke/stages.csv")).unwrap()
    };
    assert_eq!(
        stages("joined").lines().count(),
        stages("together").lines().count(),
        "each stage stands there once"
    );
    let manifest =
        std::fs::read_to_string(folder.path().join("joined/results/smoke/manifest.yaml")).unwrap();
    assert!(manifest.contains("seeds: 2\n") && !manifest.contains("first_seed"), "{manifest}");
    let verified = spinebench(folder.path(), &["verify", "--out", "joined"]);
    assert!(verified.status.success(), "{}", String::from_utf8_lossy(&verified.stderr));

    assert_eq!(gather(&["joined/results/smoke", "--out", "again"]), (Some(0), String::new()));
    assert!(
        files(&folder.path().join("again")) == joined,
        "one folder gathered is another than it was"
    );

    // What does not go together is told, and nothing is written.
    let other = folder.path().join(second).join("spec.yaml");
    let spec = std::fs::read_to_string(&other).unwrap();
    std::fs::write(&other, spec.replace("control_hz: 5.0", "control_hz: 4.0")).unwrap();
    let sweep = ["--sweep", "gp.kernel=matern32,matern52", "--set", "name=swept", "--out", "sweep"];
    run(
        folder.path(),
        &[&[SMOKE, "--seeds", "1", "--cache", "cache", "--set", "claims=[]"], &sweep[..]].concat(),
    );
    let cut = folder.path().join(third).join("trials.csv");
    let trials = std::fs::read_to_string(&cut).unwrap();
    std::fs::write(
        &cut,
        trials.lines().take(20).map(|line| line.to_owned() + "\n").collect::<String>(),
    )
    .unwrap();
    let cases: [(&[&str], &str); 6] = [
        (&[first, third], "third/results/smoke/trials.csv: found 19 trials, expected "),
        (
            &["again/results/smoke", second],
            "second/results/smoke: found another spec, expected that of again/results",
        ),
        (
            &["sweep/results/swept", second],
            "sweep/results/swept: found a sweep, expected repetitions of one experiment",
        ),
        (
            &[first, first],
            "first/results/smoke: found repetitions from 0 on, expected 1, which follows \
             first/results",
        ),
        (&[first, "nowhere"], "nowhere/spec.yaml"),
        (&[], "RESULTS/EXPERIMENT"),
    ];
    for (arguments, said) in cases {
        let (status, words) = gather(&[arguments, &["--out", "none"]].concat());
        assert!(status == Some(2) && words.contains(said), "{arguments:?}: {status:?} {words}");
        assert!(!folder.path().join("none").exists(), "{arguments:?}");
    }
}

#[test]
fn a_plan_counts_runs_and_stages_and_runs_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let plan = |arguments: &[&str]| {
        let output = spinebench(folder.path(), &[&["plan"], arguments].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let text = plan(&[SMOKE, "--seeds", "3"]);
    // Per seed and training: A, B and pi_real in three modes, C in two, and four policies tracking.
    let runs = 3 * 2 * (3 * 3 + 2 + 4);
    assert!(
        text.starts_with(&format!("smoke: {runs} runs over 3 seeds, 0 stored, {runs} left\n")),
        "{text}"
    );
    assert_eq!(text.lines().filter(|line| line.starts_with("  left ")).count(), runs);
    assert!(text.contains("collect_sim           0 stored      3 left"), "{text}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "a plan writes nothing");

    let small = "runs.reach=[{policies: [a], modes: [open], gp_points: [20]}]";
    run(folder.path(), &[SMOKE, "--seeds", "1", "--set", small, "--set", "claims=[]"]);
    let text = plan(&[SMOKE, "--seeds", "1"]);
    // The tracking runs and A's open loop are there now, for both kinds of training.
    assert!(text.starts_with("smoke: 30 runs over 1 seeds, 10 stored, 20 left\n"), "{text}");
}

/// The recording is shared; Gaussian processes and what hangs on them are then a matter of the
/// training.
#[test]
fn p_sim_from_the_forward_network_is_an_experiment_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let small = "runs.reach=[{policies: [a, b], modes: [closed], gp_points: [20]}]";
    let arguments =
        [SMOKE, "--seeds", "1", "--set", small, "--set", "runs.track=null", "--set", "claims=[]"];
    run(folder.path(), &[&arguments[..], &["--out", "rod"]].concat());
    let network =
        ["--out", "network", "--set", "gp_points.p_sim=network", "--set", "runs.forward=false"];
    let (computed, _) = run(folder.path(), &[&arguments[..], &network[..]].concat());
    // For both kinds of training two processes with their scores, B's network, and the trials of A
    // and B.
    assert_eq!(computed, 2 * (2 * 2 + 1 + 2));
    let read = |out: &str, name: &str| {
        std::fs::read_to_string(folder.path().join(out).join("results/smoke").join(name)).unwrap()
    };
    let trainings = |out: &str| -> Vec<String> {
        read(out, "gp.csv")
            .lines()
            .skip(1)
            .map(|line| line.split(',').nth(1).unwrap().to_owned())
            .collect()
    };
    assert_eq!(trainings("rod"), ["any", "any"]);
    assert_eq!(trainings("network"), ["converged", "converged", "paper", "paper"]);
    assert!(
        read("network", "networks.csv").contains(",forward,"),
        "what stands for the rod is published"
    );
    assert_ne!(read("rod", "trials.csv"), read("network", "trials.csv"));
}

#[test]
fn experiments_share_their_stages() {
    let folder = tempfile::tempdir().unwrap();
    let other = folder.path().join("other.yaml");
    let text = format!(
        "extends: {SMOKE}\nname: other\nruns: {{gap: {{rows: 30}}, forward: false}}\nclaims: []\n"
    );
    std::fs::write(&other, text).unwrap();
    let count = |specs: &[&str]| {
        let output = spinebench(folder.path(), &[&["plan", "--seeds", "1"], specs].concat());
        let text = String::from_utf8(output.stdout).unwrap();
        let line = text.lines().find(|line| line.starts_with("stages: ")).unwrap();
        line.split(' ').filter_map(|word| word.parse::<usize>().ok()).sum::<usize>()
    };
    let both = count(&[SMOKE, other.to_str().unwrap()]);
    assert_eq!(
        both,
        count(&[SMOKE]) + 1,
        "only the thinning of the gap is the other experiment's own"
    );
}

#[test]
fn a_log_for_machines_and_the_strict_answer() {
    let folder = tempfile::tempdir().unwrap();
    let small = "runs.reach=[{policies: [a], modes: [open], gp_points: [20]}]";
    let tiny = [
        "run",
        SMOKE,
        "--seeds",
        "1",
        "--set",
        small,
        "--set",
        "runs.track=null",
        "--set",
        "claims=[]",
    ];
    let output = spinebench(folder.path(), &[&tiny[..], &["--log", "json"]].concat());
    assert!(output.status.success());
    let said = String::from_utf8(output.stderr).unwrap();
    let events: Vec<serde_json::Value> =
        said.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(events[0]["event"], "planned");
    let finished = events.iter().filter(|event| event["event"] == "finished").count();
    assert_eq!(finished as u64, events[0]["compute"].as_u64().unwrap());

    // A load that the rod's solver cannot carry: trials are rows with a status, the run goes on, and
    // the exit status says that a cell has no result; --strict counts trials.
    let stuck = ["--set", "modes.open.effects=[{tip_load: {mass_kg: 14}}]", "--out", "stuck"];
    let lenient = spinebench(folder.path(), &[&tiny[..], &stuck[..]].concat());
    assert_eq!(lenient.status.code(), Some(1));
    let said = String::from_utf8(lenient.stderr).unwrap();
    assert!(
        said.contains("error: every trial of reach: policy a, mode open, training converged, gp_points 20 failed (3 trials, first failure: plant: rod solver")
            && said.contains("and every trial of 1 other cell"),
        "{said}"
    );
    let strict = spinebench(folder.path(), &[&tiny[..], &stuck[..], &["--strict"]].concat());
    assert_eq!(strict.status.code(), Some(1));
    let said = String::from_utf8(strict.stderr).unwrap();
    assert!(said.contains("error: 6 trials failed"), "{said}");
    let trials =
        std::fs::read_to_string(folder.path().join("stuck/results/smoke/trials.csv")).unwrap();
    assert_eq!(trials.matches("rod solver").count(), 6, "{trials}");
    let table =
        std::fs::read_to_string(folder.path().join("stuck/results/smoke/table1.md")).unwrap();
    assert!(table.contains("6 trials without an error value"), "{table}");

    // Data that cannot be collected: everything else is written, and the exit status says so even
    // when quiet.
    let heavy = "plant.simulated.model.effects=[{tip_load: {mass_kg: 14}}]";
    let lost = spinebench(
        folder.path(),
        &[&tiny[..], &["--set", heavy, "--out", "lost", "--quiet"]].concat(),
    );
    assert_eq!(lost.status.code(), Some(1));
    let said = String::from_utf8(lost.stderr).unwrap();
    assert!(said.contains("stages failed, the first is "), "{said}");
    assert!(said.contains("note: gp_pool predefined points (seed 0) failed"), "{said}");
    let trials =
        std::fs::read_to_string(folder.path().join("lost/results/smoke/trials.csv")).unwrap();
    assert_eq!(trials.matches("gp_pool: rod solver").count(), 6, "{trials}");
}

/// A process with inducing points and a mean function runs through fits, networks and trials; its
/// table tells them apart.
#[test]
fn sparse_processes_and_means_are_swept_fields() {
    let folder = tempfile::tempdir().unwrap();
    let spec = format!(
        "extends: {SMOKE}\nname: sparse\nseeds: 1\ntraining: {{paper: null}}\ngp: \
         {{inducing_points: 15}}\nruns:\n  gap: null\n  forward: false\n  track: null\n  \
         gp_points: [60]\n  gp_coverage: [0.9]\n  gp_leave_one_out: [0.5, 0.9]\n  reach: \
         [{{policies: [a, a_online], modes: [closed], gp_points: [60]}}]\nfigures: []\nclaims: \
         []\nsweep: {{gp.approximation: [exact, sgpr, fitc], gp.mean: [zero, linear]}}\n"
    );
    std::fs::write(folder.path().join("sparse.yaml"), spec).unwrap();
    run(folder.path(), &["sparse.yaml", "--out", "out", "--cache", "cache"]);
    let results = folder.path().join("out/results/sparse");
    let table = std::fs::read_to_string(results.join("gp.csv")).unwrap();
    let at = table
        .lines()
        .next()
        .unwrap()
        .split(',')
        .position(|name| name == "log_marginal_likelihood")
        .unwrap();
    let likelihoods: Vec<&str> =
        table.lines().skip(1).map(|row| row.split(',').nth(at).unwrap()).collect();
    assert_eq!(likelihoods.len(), 6, "{table}");
    let left_out = std::fs::read_to_string(results.join("gp_leave_one_out.csv")).unwrap();
    assert_eq!(left_out.lines().count(), 1 + 6 * 3 * 2, "{left_out}");
    let mut distinct = likelihoods.clone();
    distinct.sort_unstable();
    distinct.dedup();
    assert_eq!(
        distinct.len(),
        6,
        "every approximation with every mean is a process of its own: {likelihoods:?}"
    );
}

/// Trials of fixed duration: tables, a figure, and the same bytes for any threads.
#[test]
fn controllers_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let spec = format!(
        "extends: {SMOKE}\nname: told\nseeds: 2\nruns:\n  gap: null\n  gp_points: []\n  forward: \
         false\n  reach: []\n  track: null\n  response:\n    duration_s: 4\n    cells:\n      - \
         {{policies: [a, b, integral, online_jacobian, model_integral, mpc, a_integral, dagger], \
         modes: [open, closed, closed_load], gp_points: [20]}}\n  pace:\n    lap_s: 8\n    \
         lead_in_s: 2\n    speeds: [1, 2]\n    cells:\n      - {{policies: [integral, mpc], modes: \
         [closed], gp_points: [20]}}\npolicies:\n  dagger: {{rounds: 2, robots: 4, targets: 4, \
         ticks: 12}}\nfigures: [controllers]\nclaims: []\n"
    );
    std::fs::write(folder.path().join("told.yaml"), spec).unwrap();
    run(folder.path(), &["told.yaml", "--threads", "1", "--out", "one", "--cache", "cache1"]);
    run(folder.path(), &["told.yaml", "--threads", "2", "--out", "two", "--cache", "cache2"]);
    assert!(
        files(&folder.path().join("one")) == files(&folder.path().join("two")),
        "results depend on the threads"
    );
    let results = folder.path().join("one/results/told");
    let rows = |name: &str| std::fs::read_to_string(results.join(name)).unwrap();
    let responses = rows("responses.csv");
    assert!(responses.lines().skip(1).all(|line| line.ends_with(",ok")), "{responses}");
    assert!(
        !responses.contains(",integral,open,"),
        "a policy that needs feedback has no open loop"
    );
    // Two seeds and trainings, three targets: three policies in two modes, five in three.
    assert_eq!(responses.lines().count(), 1 + 2 * 2 * 3 * (3 * 2 + 5 * 3));
    assert_eq!(rows("paces.csv").lines().count(), 1 + 2 * 2 * 2 * 2);
    assert!(
        ["| online Jacobian |", "| MPC |"]
            .iter()
            .all(|label| rows("controllers.md").contains(label))
    );
    assert!(folder.path().join("one/plots/told/controllers.png").is_file());
}

/// A change that nobody announces: it is noticed, named and mended, and every table and the figure
/// say so.
#[test]
fn a_changed_robot_is_noticed_named_and_mended() {
    let folder = tempfile::tempdir().unwrap();
    let spec = format!(
        "extends: {SMOKE}\nname: mended\nseeds: 1\ntraining: {{paper: null}}\nruns:\n  gap: \
         null\n  gp_points: []\n  forward: false\n  reach: []\n  track: null\n  repair:\n    \
         gp_points: 20\n    recordings: {{trials_before: 6}}\n    monitor: {{calibration_s: 120, \
         false_alarm_s: 600, watched_s: 120}}\n    changes: {{load: [{{tip_load: {{mass_kg: \
         0.03}}}}]}}\n    cells:\n      - {{policies: [a, b, pi_real, integral], modes: [closed], \
         gp_points: [20], real_points: [200]}}\nfigures: [repair]\nclaims: []\n"
    );
    std::fs::write(folder.path().join("mended.yaml"), spec).unwrap();
    run(folder.path(), &["mended.yaml", "--out", "out", "--cache", "cache"]);
    let results = folder.path().join("out/results/mended");
    let table = |name: &str| std::fs::read_to_string(results.join(name)).unwrap();
    let monitors = table("monitors.csv");
    assert_eq!(monitors.lines().count(), 2, "inherited training is dropped: {monitors}");
    assert_eq!(table("identifications.csv").lines().count(), 2);
    let repairs = table("repairs.csv");
    // Truth, time to the alarm, and the line that the model got: none of them empty.
    let row = repairs.lines().nth(1).unwrap();
    assert!(
        row.starts_with("0,converged,load,tip_load: {mass_kg: 0.03},") && row.ends_with(",ok"),
        "{row}"
    );
    assert!(!row.contains("},,") && row.matches("tip_load: {mass_kg: 0.03").count() == 2, "{row}");
    // Targets are drawn from what the unchanged robot reaches: its tip comes nearer to them than
    // that of the loaded one.
    let nearest_m = |name: &str| {
        let text = table(name);
        let place = text
            .lines()
            .next()
            .unwrap()
            .split(',')
            .rev()
            .position(|column| column == "nearest_m")
            .unwrap();
        text.lines().nth(1).unwrap().split(',').rev().nth(place).unwrap().parse::<f64>().unwrap()
    };
    let (unchanged_m, loaded_m) = (nearest_m("identifications.csv"), nearest_m("repairs.csv"));
    assert!(
        unchanged_m < 0.002 && unchanged_m < loaded_m && loaded_m < 0.02,
        "{unchanged_m} {loaded_m}"
    );
    // Three targets; before, changed, repaired, moved and new points for A and B, new data for
    // pi_real; nothing to mend in feedback that was trained on nothing.
    let trials = table("repair_trials.csv");
    assert_eq!(trials.lines().count(), 1 + 3 * (5 + 5 + 3 + 2), "{trials}");
    assert!(trials.lines().skip(1).all(|line| line.ends_with(",ok")), "{trials}");
    assert!(table("repair.md").contains("| load | A |"), "{}", table("repair.md"));
    assert!(folder.path().join("out/plots/mended/repair.png").is_file());
}
