//! Bad specs: one error with file, line, column, key, what was found and what was expected; exit
//! status 2; nothing written.

use std::path::Path;
use std::process::{Command, Output};

/// Runs the program on `bad.yaml` in `folder`, which extends the smoke experiment.
fn run(folder: &Path, text: &str, more: &[&str]) -> Output {
    let experiments = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments");
    let spec = format!("extends: {}/smoke.yaml\n{text}", experiments.display());
    std::fs::write(folder.join("bad.yaml"), spec).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_spinebench"));
    command.current_dir(folder).args(["run", "bad.yaml", "--out", "out", "--quiet"]).args(more);
    command.env("SPINEBENCH_CACHE", ".spinebench/cache").output().unwrap()
}

/// The text after `extends:` (which is line 1), and how the error begins after `error: `.
const BAD: &[(&str, &str)] = &[
    // Unknown keys, with the nearest known one.
    (
        "duration_ms: 5",
        "bad.yaml:2:1: duration_ms: found the unknown key `duration_ms`, expected one of",
    ),
    ("seedz: 5", "bad.yaml:2:1: seedz: found the unknown key `seedz`"),
    ("explore: {point: 5}", "bad.yaml:2:11: explore.point: found the unknown key `point`"),
    ("gp:\n  kernle: se_ard", "bad.yaml:3:3: gp.kernle: found the unknown key `kernle`"),
    (
        "network: {optimization_itarations: bull}",
        "bad.yaml:2:11: network.optimization_itarations: found the unknown key",
    ),
    (
        "policies: {c: {error_mm: 15}}",
        "bad.yaml:2:16: policies.c.error_mm: found the unknown key `error_mm`",
    ),
    (
        "modes: {closed: {load_kg: 1}}",
        "bad.yaml:2:18: modes.closed.load_kg: found the unknown key `load_kg`",
    ),
    (
        "runs:\n  reach:\n    - {policy: a}",
        "bad.yaml:4:8: runs.reach[0].policy: found the unknown key `policy`",
    ),
    (
        "claims: [{claim: x, statement: y, relation: {more: {}}}]",
        "bad.yaml:2:46: claims[0].relation.more: found the unknown name `more`",
    ),
    // Wrong types.
    ("seeds: many", "bad.yaml:2:8: seeds: found text \"many\", expected a whole number"),
    ("seeds: 1.5", "bad.yaml:2:8: seeds: found floating point `1.5`, expected a whole number"),
    (
        "explore: {points: -3}",
        "bad.yaml:2:19: explore.points: found integer `-3`, expected a whole number, 0 or more",
    ),
    ("control_hz: [5]", "bad.yaml:2:13: control_hz: found sequence, expected a number"),
    ("training: paper", "bad.yaml:2:11: training: found text \"paper\", expected a mapping"),
    (
        "runs: {reach: {policies: [a]}}",
        "bad.yaml:2:15: runs.reach: found a mapping, expected a list",
    ),
    (
        "policies: {c: {check: sometimes}}",
        "bad.yaml:2:23: policies.c.check: found the unknown name `sometimes`",
    ),
    (
        "gp: {kernel: se_adr}",
        "bad.yaml:2:14: gp.kernel: found the unknown kernel `se_adr`, expected",
    ),
    // Ranges.
    ("seeds: 0", "bad.yaml:2:8: seeds: found 0, expected 1 to 1000"),
    ("control_hz: 0", "bad.yaml:2:13: control_hz: found 0, expected a rate above 0"),
    ("control_hz: .nan", "bad.yaml:2:13: control_hz: found .nan, expected a rate above 0"),
    ("name: ../elsewhere", "bad.yaml:2:7: name: found `../elsewhere`, expected a name of letters"),
    (
        "network: {train_share: 1.7}",
        "bad.yaml:2:24: network.train_share: found 1.7, expected 0.05 to 0.95",
    ),
    ("network: {hidden: 0}", "bad.yaml:2:19: network.hidden: found 0, expected 1 to 1024"),
    (
        "network: {stop_at_validation_mae_m: 0.01}",
        "bad.yaml:2:37: network.stop_at_validation_mae_m: found 0.01, expected null",
    ),
    (
        "runs: {gp_points: [20], gp_coverage: [0.9, 95]}",
        "bad.yaml:2:44: runs.gp_coverage[1]: found 95, expected a share",
    ),
    (
        "population: {most_effects: 99}",
        "bad.yaml:2:28: population.most_effects: found 99, expected at least 1, and no",
    ),
    (
        "population: {effects: [creeep]}",
        "bad.yaml:2:23: population.effects: found `creeep`, expected names of effects",
    ),
    (
        "population: {strenght: 1}",
        "bad.yaml:2:14: population.strenght: found the unknown key `strenght`",
    ),
    (
        "plant: {constant_curvature: {}}\nmodes: {closed_load: {feedback: closed, effects: \
         []}}\npopulation: {}",
        "bad.yaml:2:8: plant: found a mapping, expected a `simulated` or `external` robot, to which `population` \
         adds effects",
    ),
    (
        "policies: {integral: {gain: -0.1}}",
        "bad.yaml:2:29: policies.integral.gain: found -0.1, expected a finite",
    ),
    (
        "policies: {online_jacobian: {gain: 1.5}}",
        "bad.yaml:2:36: policies.online_jacobian.gain: found 1.5, expected",
    ),
    (
        "policies: {c_hysteresis: {stay_below_m: 0.01}}",
        "bad.yaml:2:41: policies.c_hysteresis.stay_below_m: found 0.01, expected at most \
         `switch_above_m` (0.004)",
    ),
    (
        "policies: {mpc: {horizon: 500}}",
        "bad.yaml:2:27: policies.mpc.horizon: found 500, expected a whole number from 1",
    ),
    (
        "network: {kind: transformer}",
        "bad.yaml:2:17: network.kind: found the unknown name `transformer`, expected one of \
         `elman`, `gru`, `lstm`, `feed_forward`",
    ),
    ("network: {members: 0}", "bad.yaml:2:20: network.members: found 0, expected 1 to 100"),
    (
        "policies: {mpc: {disturbance: {noise_m: 0}}}",
        "bad.yaml:2:41: policies.mpc.disturbance.noise_m: found 0, expected a finite number above \
         0",
    ),
    (
        "policies: {model_integral: {slack_m: -1}}",
        "bad.yaml:2:38: policies.model_integral.slack_m: found -1, expected a finite number of at \
         least 0",
    ),
    (
        "model: {replay: {recording: none.csv}}\nruns: {reach: [{policies: [mpc], modes: [closed], \
         gp_points: [20]}]}",
        "bad.yaml:2:8: model: found a mapping, expected a model with equations",
    ),
    (
        "model: {constant_curvature: {}}\nruns: {reach: [{policies: [dagger], modes: [closed]}]}",
        "bad.yaml:2:8: model: found a mapping, expected a `simulated` model, as policy `dagger` \
         needs",
    ),
    (
        "runs: {response: {cells: [{policies: [mpc], modes: [closed]}]}}",
        "bad.yaml:2:27: runs.response.cells[0].gp_points: found nothing, expected sizes for policy \
         `mpc`",
    ),
    (
        "runs: {repair: {gp_points: 20, changes: {load: [{tip_load: {mass_kg: 0.02}}]}, cells: \
         [{policies: [mpc], modes: [closed], gp_points: [20]}]}}",
        "bad.yaml:2:100: runs.repair.cells[0].policies[0]: found `mpc`, expected a policy that \
         does not use the model",
    ),
    (
        "runs: {response: {duration_s: 0, cells: [{policies: [a_integral], modes: [closed], \
         gp_points: [20]}]}}",
        "bad.yaml:2:31: runs.response.duration_s: found 0, expected 1 to 600 s",
    ),
    // Repairs: changes, recordings, monitor.
    (
        "runs: {repair: {changes: {}, cells: [{policies: [integral], modes: [closed]}]}}",
        "bad.yaml:2:26: runs.repair.changes: found a mapping, expected at least one change",
    ),
    (
        "runs: {repair: {gp_points: 20, changes: {load: [{tip_load: {mass_kg: -1}}]}, cells: \
         [{policies: [integral], modes: [closed]}]}}",
        "bad.yaml:2:70: runs.repair.changes.load[0].tip_load.mass_kg: found -1, expected",
    ),
    (
        "runs: {repair: {gp_points: 20, recordings: {trials_after: 1}, changes: {load: [{tip_load: \
         {mass_kg: 0.02}}]}, cells: [{policies: [integral], modes: [closed]}]}}",
        "bad.yaml:2:59: runs.repair.recordings.trials_after: found 1, expected 2 to 1000 trials \
         with at least 30 rows",
    ),
    (
        "runs: {repair: {gp_points: 20, identification: {most_effects: 0}, changes: {load: \
         [{tip_load: {mass_kg: 0.02}}]}, cells: [{policies: [integral], modes: [closed]}]}}",
        "bad.yaml:2:63: runs.repair.identification.most_effects: found 0, expected a whole number \
         of at least 1",
    ),
    (
        "runs: {repair: {gp_points: 20, monitor: {patience_s: 0}, changes: {load: [{tip_load: \
         {mass_kg: 0.02}}]}, cells: [{policies: [integral], modes: [closed]}]}}",
        "bad.yaml:2:54: runs.repair.monitor.patience_s: found 0, expected 1 to 36000 s",
    ),
    (
        "gp_points: {p_sim: network}\nruns: {repair: {gp_points: 20, changes: {load: [{tip_load: \
         {mass_kg: 0.02}}]}, cells: [{policies: [integral], modes: [closed]}]}}",
        "bad.yaml:2:20: gp_points.p_sim: found `network`, expected `rod`, because `runs.repair`",
    ),
    (
        "runs: {response: {cells: [{policies: [a_integral], modes: [closed]}]}}",
        "bad.yaml:2:27: runs.response.cells[0].gp_points: found nothing, expected sizes for policy \
         `a_integral`",
    ),
    (
        "runs: {pace: {speeds: [1, 0], cells: [{policies: [integral], modes: [closed]}]}}",
        "bad.yaml:2:27: runs.pace.speeds[1]: found 0, expected 0.1 to 100 times",
    ),
    (
        "training: {paper: {inverse_mae_m: -0.1}}",
        "bad.yaml:2:35: training.paper.inverse_mae_m: found -0.1, expected a length above 0",
    ),
    (
        "explore: {max_step_m: -0.003}",
        "bad.yaml:2:23: explore.max_step_m: found -0.003, expected a finite number above 0",
    ),
    (
        "policies: {a: {tolerance_m: 0}}",
        "bad.yaml:2:29: policies.a.tolerance_m: found 0, expected a finite number above 0",
    ),
    (
        "plant: {simulated: {noise_m: -1}}",
        "bad.yaml:2:30: plant.simulated.noise_m: found -1, expected",
    ),
    (
        "modes: {closed_load: {effects: [{tip_load: {mass_kg: -0.02}}]}}",
        "bad.yaml:2:54: modes.closed_load.effects[0].tip_load.mass_kg: found -0.02",
    ),
    (
        "modes: {closed_load: {effects: [{tip_lode: {mass_kg: 0.02}}]}}",
        "bad.yaml:2:34: modes.closed_load.effects[0].tip_lode: found the unknown name `tip_lode`",
    ),
    // Wrong units, and more than a machine holds.
    (
        "plant: {simulated: {noise_m: 0.5}}",
        "bad.yaml:2:30: plant.simulated.noise_m: found 0.5 (if that is in mm, write 0.0005 m), \
         expected 0 to 0.05",
    ),
    (
        "explore: {max_pull_m: 20}",
        "bad.yaml:2:23: explore.max_pull_m: found 20, expected at most 0.06 m, the travel of",
    ),
    (
        "explore: {points: 20000000}",
        "bad.yaml:2:19: explore.points: found 20000000, expected 1 to 10000000",
    ),
    ("seeds: 600\nfirst_seed: 401", "bad.yaml:3:13: first_seed: found 401, expected 0 to 400"),
    ("seeds: 1001", "bad.yaml:2:8: seeds: found 1001, expected 1 to 1000"),
    ("name:", "bad.yaml:2:"),
    (
        "modes: {odd mode!: {feedback: closed}}",
        "bad.yaml:2:20: modes.odd mode!: found a mapping, expected a name of",
    ),
    (
        "plant: 3",
        "bad.yaml:2:8: plant: found integer `3`, expected one alternative with its settings",
    ),
    // Sizes larger than the data.
    (
        "network: {window: 8}\nruns:\n  reach:\n    - {policies: [pi_real], modes: [closed], \
         real_points: [10]}",
        "bad.yaml:5:60: runs.reach[0].real_points[0]: found 10, expected about 13 or more, enough \
         for a window",
    ),
    (
        "runs:\n  reach:\n    - {policies: [a], modes: [closed], gp_points: [10, 81]}",
        "bad.yaml:4:56: runs.reach[0].gp_points[1]: found 81, expected 2 to 80, the number of \
         predefined points",
    ),
    (
        "runs:\n  reach:\n    - {policies: [pi_real], modes: [closed], real_points: [241]}",
        "bad.yaml:4:60: runs.reach[0].real_points[0]: found 241, expected 10 to 240, the number of \
         collected points",
    ),
    (
        "targets: {drawn: 21}",
        "bad.yaml:2:18: targets.drawn: found 21, expected at most `pool` (20)",
    ),
    (
        "targets: {pool: 50}",
        "bad.yaml:2:17: targets.pool: found 50 for a sweep of 49 nodes, expected at most",
    ),
    (
        "runs: {track: {real_points: 500}}",
        "bad.yaml:2:29: runs.track.real_points: found 500, expected 10 to 240",
    ),
    ("runs: {gp_points: [100]}", "bad.yaml:2:20: runs.gp_points[0]: found 100, expected 2 to 80"),
    ("runs: {gap: {rows: 241}}", "bad.yaml:2:20: runs.gap.rows: found 241, expected 1 to 240"),
    // Empty or doubled sweeps, missing sizes, unknown names.
    (
        "runs:\n  reach:\n    - {policies: [], modes: [closed]}",
        "bad.yaml:4:18: runs.reach[0].policies: found an empty list, expected at least one value",
    ),
    (
        "runs:\n  reach:\n    - {policies: [a], modes: [closed], gp_points: []}",
        "bad.yaml:4:51: runs.reach[0].gp_points: found an empty list, expected at least one value",
    ),
    (
        "runs:\n  reach:\n    - {policies: [a], modes: [closed], gp_points: [20, 20]}",
        "bad.yaml:4:56: runs.reach[0].gp_points[1]: found 20, expected each value once",
    ),
    (
        "runs:\n  reach:\n    - {policies: [a], modes: [closed]}",
        "bad.yaml:4:7: runs.reach[0].gp_points: found nothing, expected sizes for policy `a`",
    ),
    (
        "runs:\n  reach:\n    - {policies: [d], modes: [closed]}",
        "bad.yaml:4:19: runs.reach[0].policies[0]: found `d`, expected one of `a`",
    ),
    (
        "runs:\n  reach:\n    - {policies: [a], modes: [ajar], gp_points: [20]}",
        "bad.yaml:4:31: runs.reach[0].modes[0]: found `ajar`, expected one of",
    ),
    ("figures: [fig5, fig5]", "bad.yaml:2:17: figures[1]: found `fig5`, expected each figure once"),
    ("figures: [fig9]", "bad.yaml:2:11: figures[0]: found `fig9`, expected one of"),
    ("training: {}\nclaims: []\nseeds: 0", "bad.yaml:4:8: seeds"),
    // Claims that the rows cannot decide.
    (
        "claims: [{claim: x, statement: y, relation: {near: {metric: {gp_error: {points: 33}}, \
         figure: 1, tolerance: 1}}}]",
        "bad.yaml:2:61: claims[0].relation.near.metric: found a mapping, expected one of the \
         fitted sizes",
    ),
    (
        "claims: [{claim: x, statement: y, relation: {near: {metric: {track_time: {policy: d}}, \
         figure: 1, tolerance: 1}}}]",
        "bad.yaml:2:61: claims[0].relation.near.metric: found a mapping, expected a policy of \
         `runs.track`",
    ),
    // Files.
    (
        "model: {simulated: {model: nowhere.yaml}}",
        "bad.yaml:2:28: model.simulated.model: found no file `nowhere.yaml`",
    ),
    ("plant: {hologram: {}}", "bad.yaml:2:"),
    ("name: [", "bad.yaml:3:1: found"),
    ("name: a\nname: b", "bad.yaml:"),
    (
        "runs: {discovery: {recordings: [{truth: none.csv}]}}",
        "bad.yaml:2:41: runs.discovery.recordings[0].truth: found none.csv: cannot read",
    ),
    (
        "runs: {discovery: {batches: []}}",
        "bad.yaml:2:29: runs.discovery.batches: found an empty list, expected",
    ),
];

#[test]
fn every_bad_spec_is_refused_with_its_place_and_nothing_is_written() {
    let mut wrong = Vec::new();
    for (text, expected) in BAD {
        let folder = tempfile::tempdir().unwrap();
        let output = run(folder.path(), text, &[]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{text}\n{said}");
        if !said.starts_with(&format!("error: {expected}")) {
            wrong.push(format!("{text}\n  said   {said}  wanted error: {expected}"));
        }
        assert_eq!(said.lines().count(), 1, "{text}\n{said}");
        assert!(output.stdout.is_empty(), "{text}");
        let left: Vec<_> = std::fs::read_dir(folder.path())
            .unwrap()
            .flatten()
            .map(|file| file.file_name())
            .collect();
        assert_eq!(left, ["bad.yaml"], "{text}");
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn overrides_are_checked_like_files() {
    let cases = [
        (
            "gp.starts=-3",
            "error: --set gp.starts=-3: gp.starts: found integer `-3`, expected a whole number, 0 \
             or more",
        ),
        ("gp.startz=3", "error: --set gp.startz=3: gp.startz: found the unknown key `startz`"),
        (
            "targets.drawn=900",
            "error: --set targets.drawn=900: targets.drawn: found 900, expected at most `pool` \
             (20)",
        ),
        ("gp", "error: --set gp: (whole document): found `gp`, expected path.to.key=value"),
        ("gp.starts=[", "error: --set gp.starts=[: found"),
    ];
    for (set, expected) in cases {
        let folder = tempfile::tempdir().unwrap();
        let output = run(folder.path(), "", &["--set", set]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{set}\n{said}");
        assert!(said.starts_with(expected), "{said}");
        assert!(!folder.path().join("out").exists());
    }
}

#[test]
fn all_faults_of_a_spec_are_told_at_once_and_in_the_order_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(
        folder.path(),
        "sweeps: {}\nexplore: {point: 5, points: many}\nseeds: few",
        &["--set", "policies.x.y=3"],
    );
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{said}");
    let expected = [
        "bad.yaml:2:1: sweeps: found the unknown key `sweeps`",
        "bad.yaml:3:11: explore.point: found the unknown key `point`",
        "bad.yaml:3:29: explore.points: found text \"many\"",
        "bad.yaml:4:8: seeds: found text \"few\"",
        "--set policies.x.y=3: policies.x: found the unknown key `x`",
    ];
    assert_eq!(said.lines().count(), expected.len(), "{said}");
    for fault in expected {
        assert!(
            said.lines().any(|line| line.starts_with(&format!("error: {fault}"))),
            "{fault}\n{said}"
        );
    }
    // The keys of the document itself are among the known ones.
    assert!(said.contains("`extends`, `sweep` (did you mean `sweep`?)"), "{said}");
}

#[test]
fn messages_of_the_parser_are_sentences() {
    let folder = tempfile::tempdir().unwrap();
    let said = |text: &str| String::from_utf8(run(folder.path(), text, &[]).stderr).unwrap();
    let tab = said("gp:\n\tstarts: 3");
    assert!(tab.starts_with("error: bad.yaml:3:1: found a tab character"), "{tab}");
    assert!(tab.contains("expected YAML, which is indented by spaces"), "{tab}");
    let open = said("gp: {starts: 3");
    assert!(open.contains("found something else, expected YAML with"), "{open}");
    let twice = "found this key twice, expected it once\n";
    let below = said("gp:\n  starts: 3\n  starts: 4");
    assert_eq!(below, format!("error: bad.yaml:3:3: gp.starts: {twice}"));
    let at_root = said("seeds: 1\nseeds: 2");
    assert_eq!(at_root, format!("error: bad.yaml:2:1: seeds: {twice}"));
}

#[test]
fn usage_errors_and_missing_specs_end_with_2() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_spinebench"));
        command.current_dir(folder.path()).args(arguments).output().unwrap()
    };
    let missing = run(&["run", "nowhere.yaml"]);
    assert_eq!(missing.status.code(), Some(2));
    let said = String::from_utf8(missing.stderr).unwrap();
    let place = folder.path().canonicalize().unwrap();
    let expected = format!(
        "found no file `nowhere.yaml` in {}, expected the name of a YAML file",
        place.display()
    );
    assert_eq!(said, format!("error: nowhere.yaml: {expected}\n"));
    for arguments in
        [&["run"] as &[&str], &["frobnicate"], &["run", "x.yaml", "--seeds", "some"], &["verify"]]
    {
        assert_eq!(run(arguments).status.code(), Some(2), "{arguments:?}");
    }
    assert_eq!(run(&["--help"]).status.code(), Some(0));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
