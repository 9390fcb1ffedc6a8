//! Sweeps: what they expand to, what of it is computed once, what they publish, and what is
//! refused.

use spinebench::runner::Campaign;
use spinebench::specs::ExperimentSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// One policy, one mode, one size, one seed: a handful of stages.
const TINY: [&str; 6] = [
    "--set",
    "runs={gap: null, forward: false, gp_points: [], reach: [{policies: [a], modes: [open], \
     gp_points: [20]}], track: null}",
    "--set",
    "claims=[]",
    "--seeds",
    "1",
];

fn experiments() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments")
}

fn owned(texts: &[&str]) -> Vec<String> {
    texts.iter().map(|text| (*text).to_owned()).collect()
}

/// The smoke experiment, one seed.
fn smoke(sets: &[&str], sweeps: &[&str]) -> Result<ExperimentSet, String> {
    let sets = owned(&[&["seeds=1"], sets].concat());
    ExperimentSet::read(&experiments().join("smoke.yaml"), &sets, &owned(sweeps))
        .map_err(|error| error.to_string())
}

fn stages(studies: Vec<ExperimentSet>) -> usize {
    Campaign::expand(studies).unwrap().graph.len()
}

/// Runs the program on `spec.yaml`, which extends the smoke experiment.
fn spinebench(folder: &Path, text: &str, arguments: &[&str]) -> Output {
    let spec = format!("extends: {}/smoke.yaml\n{text}", experiments().display());
    std::fs::write(folder.join("spec.yaml"), spec).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_spinebench"));
    command
        .current_dir(folder)
        .args(arguments)
        .env("SPINEBENCH_CACHE", ".spinebench/cache")
        .output()
        .unwrap()
}

#[test]
fn a_former_name_is_read_with_a_note_that_tells_the_present_one() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("old.yaml");
    let smoke_file = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/smoke.yaml");
    let text = format!("extends: {}\npolicies:\n  c: {{error_m: 0.011}}\n", smoke_file.display());
    std::fs::write(&file, text).unwrap();
    let read = |sets: &[&str], sweeps: &[&str]| {
        let owned =
            |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
        ExperimentSet::read(&file, &owned(sets), &owned(sweeps))
    };
    let note = "`policies.c.error_m` is now called `policies.c.switch_threshold_m`";
    let set = read(&[], &[]).unwrap();
    assert_eq!(set.experiment.policies.c.switch_threshold_m, 0.011);
    assert_eq!(set.notes, [format!("{}:3:7: {note}", file.display())]);
    assert!(set.to_yaml().unwrap().contains("switch_threshold_m: 0.011"));
    let set = read(&["policies.c.error_m=0.012"], &[]).unwrap();
    assert_eq!(set.experiment.policies.c.switch_threshold_m, 0.012);
    assert_eq!(set.notes[1], format!("--set policies.c.error_m=0.012: {note}"));
    let set = read(&[], &["policies.c.error_m=0.01,0.02"]).unwrap();
    assert_eq!(set.points[1].experiment.policies.c.switch_threshold_m, 0.02);
    assert_eq!(set.notes[1], format!("--sweep policies.c.error_m=0.01,0.02: {note}"));
    let wrong = read(&["policies.c.error_m=-1"], &[]).unwrap_err().to_string();
    assert!(
        wrong.starts_with("--set policies.c.error_m=-1: policies.c.switch_threshold_m: found -1"),
        "{wrong}"
    );
    let other = file.with_file_name("wrong.yaml");
    std::fs::write(&other, std::fs::read_to_string(&file).unwrap().replace("0.011", "-0.011"))
        .unwrap();
    let wrong = ExperimentSet::read(&other, &[], &[]).unwrap_err().to_string();
    assert!(
        wrong.contains("wrong.yaml:3:16: policies.c.switch_threshold_m: found -0.011"),
        "{wrong}"
    );
}

#[test]
fn a_mode_by_another_name_is_no_other_trial() {
    let reach = "runs.reach=[{policies: [a], modes: [open, blind], gp_points: [20]}]";
    let named = |mode: &str| reach.replace("blind", mode);
    let with = |mode: &str| {
        smoke(&["claims=[]", &format!("modes.{mode}={{feedback: open}}"), &named(mode)], &[])
            .unwrap()
    };
    let (one, other) = (with("blind"), with("eyes_shut"));
    assert_eq!(
        stages(vec![one.clone(), other]),
        stages(vec![one]),
        "the label of a row is in no key"
    );
}

#[test]
fn points_are_the_product_in_a_fixed_order_the_last_field_first() {
    let study =
        smoke(&[], &["gp.kernel=matern32,matern52", "policy.c.switch_threshold_m=0.005:0.03:6"])
            .unwrap();
    let names: Vec<&str> = study.sweep.iter().map(|field| field.name.as_str()).collect();
    assert_eq!(names, ["gp.kernel", "policies.c.switch_threshold_m"]);
    assert_eq!(study.points.len(), 12);
    assert_eq!(
        study.points[1].label(&study.sweep),
        "gp.kernel=matern32 policies.c.switch_threshold_m=0.01"
    );
    assert_eq!(
        study.points[7].label(&study.sweep),
        "gp.kernel=matern52 policies.c.switch_threshold_m=0.01"
    );
    for point in &study.points {
        let experiment = &point.experiment;
        let [kernel, threshold] =
            [0, 1].map(|field| study.sweep[field].values[point.values[field]].as_str());
        assert_eq!(format!("{kernel}_ard"), experiment.gp.kernel.name());
        assert_eq!(experiment.policies.c.switch_threshold_m, threshold.parse::<f64>().unwrap());
    }
}

#[test]
fn a_point_of_a_sweep_is_the_experiment_that_is_set_so() {
    let swept =
        smoke(&["gp.kernel=matern52"], &["policy.c.switch_threshold_m=0.005:0.03:6"]).unwrap();
    let set =
        smoke(&["gp.kernel=matern52", "policies.c.switch_threshold_m=0.015", "claims=[]"], &[])
            .unwrap();
    assert_eq!(*swept.points[2].experiment, set.experiment);
    let both = stages(vec![swept.clone(), set]);
    assert_eq!(both, stages(vec![swept]), "and shares all its stages");
}

#[test]
fn only_what_depends_on_the_swept_field_is_there_once_a_point() {
    let alone = stages(vec![smoke(&[], &[]).unwrap()]);
    let trials = 22 + 8; // reaching and tracking
    let swept = |sweep: &str| stages(vec![smoke(&[], &[sweep]).unwrap()]);
    assert_eq!(swept("policies.c.switch_threshold_m=0.005:0.03:6"), alone + 5 * trials);
    // Beyond the trials that A, B and C do: two sizes with their scores, and B's two networks.
    let pi_real = 3 * 2 + 2;
    assert_eq!(
        swept("gp.kernel=se_ard,matern32,matern52"),
        alone + 2 * (trials - pi_real + 2 * 2 + 2)
    );
    assert_eq!(swept("reach.max_steps=12,13"), alone + 22);
}

#[test]
fn fields_of_every_kind_are_swept() {
    let cases: [(&str, usize); 9] = [
        ("seed=1,2,3", 3),
        ("control_hz=4,5", 2),
        ("runs.reach[0].gp_points[0]=20,40", 2),
        ("runs.reach[0].gp_points=[20],[20, 40]", 2),
        ("modes.closed_load.effects[0].tip_load.mass_kg=0.01:0.03:3", 3),
        ("plant.simulated.model.robot.backbone.youngs_modulus_pa=log:1e9:4e9:3", 3),
        ("plant.simulated.model.effects=[],[{tip_load: {mass_kg: 0.01}}]", 2),
        (
            "gp_points.layout={grid: {rows: 8, columns: 10, max_pull_m: 0.02}},{walk: {points: 80, \
             every: 3, max_step_m: 0.003, max_pull_m: 0.02}}",
            2,
        ),
        ("explore.points=random:230:260:4:whole", 4),
    ];
    for (sweep, points) in cases {
        let study = smoke(&[], &[sweep]).unwrap_or_else(|error| panic!("{sweep}: {error}"));
        assert_eq!(study.points.len(), points, "{sweep}");
    }
    assert_eq!(
        smoke(&[], &["seed=1,2"]).unwrap().sweep[0].name,
        "spec.seed",
        "a swept column has a dot in its name"
    );
}

#[test]
fn models_are_swept_by_their_files_and_by_what_is_in_them() {
    let folder = tempfile::tempdir().unwrap();
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
    let text = format!(
        "extends: {}/smoke.yaml\nseeds: 1\nsweep:\n  plant.simulated.model: \
         [{models}/nominal.yaml, {models}/real.yaml]\n  \
         plant.simulated.model.robot.damping_time_s: [0.03, 0.04]\n  \
         modes.closed_load.effects:\n    named:\n      light: [{{tip_load: {{mass_kg: \
         0.01}}}}]\n      heavy: [{{tip_load: {{mass_kg: 0.03}}}}]\n",
        experiments().display(),
        models = models.display()
    );
    let file = folder.path().join("models.yaml");
    std::fs::write(&file, text).unwrap();
    let study = ExperimentSet::read(&file, &[], &[]).unwrap();
    assert_eq!(study.points.len(), 8);
    assert_eq!(study.sweep[2].values, ["light", "heavy"]);
    let real = smoke(&["plant.simulated.model.robot.damping_time_s=0.04"], &[]).unwrap().experiment;
    assert_eq!(
        study.points[6].experiment.plant, real.plant,
        "a number of a model goes into the file that is swept"
    );
    assert_ne!(study.points[0].experiment.plant, real.plant);

    // Resolved, the spec needs no files and is the same study.
    let resolved = folder.path().join("elsewhere.yaml");
    std::fs::write(&resolved, study.to_yaml().unwrap()).unwrap();
    let again = ExperimentSet::read(&resolved, &[], &[]).unwrap();
    assert_eq!((&again.sweep, &again.points), (&study.sweep, &study.points));
}

#[test]
fn a_spec_adds_to_what_it_extends_replaces_and_drops() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write(
        "base.yaml",
        &format!(
            "extends: {}/smoke.yaml\nsweep: {{gp.starts: [1, 2], gp.kernel: [se_ard, se_iso]}}\n",
            experiments().display()
        ),
    );
    write(
        "more.yaml",
        "extends: base.yaml\nsweep: {gp.starts: {range: {from: 1, to: 3, step: 1}}, gp.kernel: \
         null, seed: [1, 2]}\n",
    );
    let read = |sets: &[&str], sweeps: &[&str]| {
        ExperimentSet::read(&folder.path().join("more.yaml"), &owned(sets), &owned(sweeps)).unwrap()
    };
    let fields = |study: &ExperimentSet| {
        study
            .sweep
            .iter()
            .map(|field| format!("{} {}", field.name, field.values.len()))
            .collect::<Vec<_>>()
    };
    assert_eq!(fields(&read(&[], &[])), ["gp.starts 3", "spec.seed 2"]);
    assert_eq!(fields(&read(&[], &["gp.starts=5,6,7,8"])), ["gp.starts 4", "spec.seed 2"]);
    assert!(read(&["sweep=null"], &[]).sweep.is_empty());
    assert_eq!(fields(&read(&["sweep=null"], &["gp.folds=2,3"])), ["gp.folds 2"]);
}

/// The text after `extends:` (which is line 1), and how the error begins after `error: `.
const BAD_SPECS: &[(&str, &str)] = &[
    (
        "sweep: {gp.kernle: [a]}",
        "spec.yaml:2:9: gp.kernle: found the unknown key `kernle`, expected one of",
    ),
    (
        "sweep: {gp.kernel: []}",
        "spec.yaml:2:20: gp.kernel: found no values, expected at least one value",
    ),
    (
        "sweep: {gp.kernel: [se_ard, se_adr]}",
        "spec.yaml:2:29: gp.kernel: found the unknown kernel `se_adr`, expected one of",
    ),
    (
        "sweep:\n  policies.c.switch_threshold_m: [0.01, -0.01]",
        "spec.yaml:3:41: policies.c.switch_threshold_m: found -0.01, expected a finite number \
         above 0 (point 2 of 2: policies.c.switch_threshold_m=-0.01)",
    ),
    (
        "sweep:\n  gp.starts: [1, 2]\n  targets.drawn: {range: {from: 10, to: 30, count: 3}}",
        "spec.yaml:4:18: targets.drawn: found 30, expected at most `pool` (20) (point 3 of 6: \
         gp.starts=1 targets.drawn=30)",
    ),
    (
        "sweep: {gp.starts: {range: {from: 1, to: 5, count: 1}}}",
        "spec.yaml:2:52: gp.starts: found 1, expected at least 2",
    ),
    (
        "sweep: {gp.starts: {log_range: {from: 0, to: 5, count: 3}}}",
        "spec.yaml:2:39: gp.starts: found 0, expected a number above 0",
    ),
    (
        "sweep: {gp: {kernel: [a]}}",
        "spec.yaml:2:13: gp: found the unknown key `kernel`, expected a list, or one of",
    ),
    (
        "sweep: [gp.kernel]",
        "spec.yaml:2:8: sweep: found a list of 1, expected a mapping from fields to their values",
    ),
    (
        "sweep: {name: [a, b]}",
        "spec.yaml:2:15: name: found `name`, expected a field that the trials depend on",
    ),
    (
        "sweep: {seeds: [1, 2]}",
        "spec.yaml:2:16: seeds: found `seeds`, expected a field that the trials depend on",
    ),
    (
        "sweep: {\"runs.reach[7].modes\": [[open]]}",
        "spec.yaml:2:32: runs.reach[7].modes: found a list of 1 within this path, expected a field \
         of this spec",
    ),
    (
        "sweep: {control_hz.more: [1, 2]}",
        "spec.yaml:2:26: control_hz.more: found 5 within this path, expected a field",
    ),
    (
        "sweep: {policy.c.switch_threshold_m: [0.01], policies.c.error_m: [0.02]}",
        "spec.yaml:2:46: policies.c.switch_threshold_m: found a field that is already swept, \
         expected each field once",
    ),
    (
        "sweep: {plant.simulated.model: [nowhere.yaml]}",
        "spec.yaml:2:33: plant.simulated.model: found no file `nowhere.yaml` in ",
    ),
    (
        "sweep:\n  gp.noise_floor: {range: {from: 0.001, to: 0.1, count: 1000}}\n  gp.tolerance: \
         {range: {from: 0.001, to: 0.1, count: 1000}}",
        "spec.yaml:4:17: gp.tolerance: found 1000 × 1000 points, expected at most 100000 in one \
         sweep",
    ),
];
/// Arguments, and how the error begins.
const BAD_OPTIONS: &[(&[&str], &str)] = &[
    (
        &["--sweep", "gp.kernle=a,b"],
        "--sweep gp.kernle=a,b: gp.kernle: found the unknown key `kernle`",
    ),
    (&["--sweep", "gp.kernel="], "--sweep gp.kernel=: gp.kernel: found no values"),
    (
        &["--sweep", "gp.kernel"],
        "--sweep gp.kernel: (whole document): found `gp.kernel`, expected path.to.key= and values",
    ),
    (
        &["--sweep", "gp.starts=1:2"],
        "--sweep gp.starts=1:2: (whole document): found `1:2`, expected path.to.key= and values",
    ),
    (
        &["--sweep", "policies.c.switch_threshold_m=log:-1:1:5"],
        "--sweep policies.c.switch_threshold_m=log:-1:1:5: policies.c.switch_threshold_m: found -1",
    ),
    (
        &["--sweep", "gp.starts=1,2", "--sweep", "gp.starts=3,4"],
        "--sweep gp.starts=3,4: gp.starts: found a field that is already swept",
    ),
    (
        &["--set", "policy.c.switch_threshold_m=0.01", "--sweep", "policies.c.error_m=0.01,0.02"],
        "--set policy.c.switch_threshold_m=0.01: policies.c.switch_threshold_m: found a field that \
         is swept, expected",
    ),
    (
        &["--set", "gp={kernel: se_ard}", "--sweep", "gp.kernel=se_ard,se_iso"],
        "--set gp={kernel: se_ard}: gp.kernel: found a field that is swept, expected",
    ),
    (
        &["--sweep", "explore.points=240:241:3"],
        "--sweep explore.points=240:241:3: explore.points: found floating point `240.5`",
    ),
];
#[test]
fn what_cannot_be_swept_is_refused_with_its_place() {
    let mut wrong = Vec::new();
    let file = BAD_SPECS.iter().map(|(text, expected)| (*text, &[] as &[&str], *expected));
    for (text, arguments, expected) in
        file.chain(BAD_OPTIONS.iter().map(|(arguments, expected)| ("", *arguments, *expected)))
    {
        let folder = tempfile::tempdir().unwrap();
        let output = spinebench(
            folder.path(),
            text,
            &[&["run", "spec.yaml", "--out", "out", "--quiet"], arguments].concat(),
        );
        let said = String::from_utf8(output.stderr).unwrap();
        if output.status.code() != Some(2)
            || !said.starts_with(&format!("error: {expected}"))
            || said.lines().count() != 1
        {
            wrong.push(format!("{text} {arguments:?}\n  said   {said}  wanted error: {expected}"));
        }
        assert!(!folder.path().join("out").exists(), "{text} {arguments:?}");
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_sweep_publishes_tidy_tables_a_summary_and_a_figure_and_is_verified() {
    let folder = tempfile::tempdir().unwrap();
    let text = "name: kernels\nsweep: {gp.kernel: [se_ard, matern52], reach.max_steps: [3, 4]}\n";
    let run = [&["run", "spec.yaml"], &TINY[..]].concat();
    let output = spinebench(folder.path(), text, &run);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    assert!(said.contains("table1 shows one setting"), "{said}");
    let results = folder.path().join("results/kernels");
    let read = |name: &str| std::fs::read_to_string(results.join(name)).unwrap();
    let lines = |name: &str| read(name).lines().count() - 1;
    assert!(
        read("trials.csv").starts_with("gp.kernel,reach.max_steps,seed,training,policy,mode,"),
        "{}",
        read("trials.csv")
    );
    // Points, trainings, targets.
    assert_eq!(lines("trials.csv"), 4 * 2 * 3);
    assert_eq!(lines("gp.csv"), 4);
    assert_eq!(lines("sweep.csv"), 4 * (2 + 1), "two trainings that reach, and the process");
    let summary = read("sweep.csv");
    assert!(
        summary.lines().nth(1).unwrap().starts_with("se_ard,3,reach,paper,a,open,20,0,"),
        "{summary}"
    );
    assert!(summary.lines().last().unwrap().starts_with("matern52,4,gp,any,,,20,0,"), "{summary}");
    assert!(!results.join("comparisons.csv").exists(), "one repetition makes no comparison");
    for name in ["sweep.png", "sweep.svg", "sweep_gp.png"] {
        assert!(folder.path().join("plots/kernels").join(name).is_file(), "{name}");
    }
    let published = spinebench::report::Published::read(&results).unwrap();
    assert_eq!(
        (published.sweep.rows.len(), published.trials.len()),
        (12, 0),
        "no figure mixes the points' trials"
    );
    assert_eq!(published.sweep.fields[0].0, "gp.kernel");

    let verified = spinebench(folder.path(), text, &["verify", "kernels", "--quiet"]);
    assert_eq!(verified.status.code(), Some(0), "{}", String::from_utf8_lossy(&verified.stderr));
    let again = spinebench(folder.path(), text, &run);
    assert!(
        String::from_utf8_lossy(&again.stderr).contains("\n0 stages computed")
            || String::from_utf8_lossy(&again.stderr).contains("0 stages computed")
    );
}

#[test]
fn a_sweep_of_repetitions_says_which_values_make_a_difference() {
    let folder = tempfile::tempdir().unwrap();
    let text =
        "name: kernels\nsweep: {gp.kernel: [se_ard, matern52, se_iso], reach.max_steps: [3, 4]}\n";
    let output = spinebench(
        folder.path(),
        text,
        &[&["run", "spec.yaml"], &TINY[..4], &["--seeds", "3"]].concat(),
    );
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let table =
        std::fs::read_to_string(folder.path().join("results/kernels/comparisons.csv")).unwrap();
    assert!(
        table.starts_with("gp.kernel,reach.max_steps,field,reference,task,training,policy,mode,"),
        "{table}"
    );
    // Two further kernels at two lengths of a trial and one further length at three kernels; two
    // trainings that reach, and the process.
    assert_eq!(table.lines().count() - 1, (2 * 2 + 3) * 3, "{table}");
    let row = |start: &str| {
        table
            .lines()
            .find(|line| line.starts_with(start))
            .unwrap_or_else(|| panic!("{start}: {table}"))
    };
    // The length of a trial is nothing to the process: the same bits, and no difference.
    assert!(
        row("se_ard,4,reach.max_steps,3,gp,any,,,20,0,").ends_with(",0.0,0.0,0.0,3,1.0,1.0"),
        "{table}"
    );
    assert!(row("se_iso,3,gp.kernel,se_ard,reach,paper,a,open,20,0,").contains(",3,"), "{table}");
}

#[test]
fn a_plan_tells_the_points() {
    let folder = tempfile::tempdir().unwrap();
    let plan = [&["plan", "spec.yaml", "--sweep", "gp.kernel=se_ard,se_iso"], &TINY[..]].concat();
    let output = spinebench(folder.path(), "", &plan);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.starts_with("smoke: 4 runs over 1 seeds, 0 stored, 4 left\n"), "{text}");
    assert!(
        text.contains("  left   reach seed 0 paper a open gp_points 20 gp.kernel=se_iso\n"),
        "{text}"
    );
}

/// What a hundred thousand runs share is in the graph once.
#[test]
fn a_hundred_thousand_runs_share_what_they_do_not_sweep() {
    let few = smoke(&["runs.track=null"], &["policies.c.switch_threshold_m=0.001:0.1:10"]).unwrap();
    let many =
        smoke(&["runs.track=null"], &["policies.c.switch_threshold_m=0.001:0.1:4600"]).unwrap();
    let campaign = Campaign::expand([many]).unwrap();
    assert_eq!(campaign.entries[0].cells().len(), 4600 * 22);
    assert_eq!(campaign.graph.len(), stages(vec![few]) + 4590 * 22);
}

#[test]
fn the_shipped_sweeps_are_studies_and_resolved_the_same_ones() {
    let folder = tempfile::tempdir().unwrap();
    let files =
        std::fs::read_dir(experiments().join("sweeps")).unwrap().map(|file| file.unwrap().path());
    let files: Vec<_> = files.collect();
    assert!(files.len() >= 8, "{files:?}");
    for file in files {
        let study = ExperimentSet::read(&file, &[], &[]).unwrap_or_else(|error| panic!("{error}"));
        let stem = file.file_stem().unwrap().to_str().unwrap();
        assert_eq!(study.experiment.name, format!("sweep_{stem}"));
        assert_eq!(
            study.points.len(),
            study.sweep.iter().map(|field| field.values.len()).product::<usize>()
        );
        let resolved = folder.path().join("spec.yaml");
        std::fs::write(&resolved, study.to_yaml().unwrap()).unwrap();
        assert_eq!(ExperimentSet::read(&resolved, &[], &[]).unwrap(), study);
        let error = spinebench::specs::Experiment::read(&file, &[]).unwrap_err().to_string();
        assert!(error.contains("expected a spec without a sweep"), "{error}");
    }
}
