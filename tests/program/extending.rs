//! The examples of `docs/reference/extending.md`, added to a copy of the sources: one file and one line each,
//! and nothing else.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
/// What of the repository a build needs.
const SOURCES: [&str; 12] = [
    "Cargo.toml",
    "Cargo.lock",
    "build.rs",
    "build",
    "src",
    "tests",
    "benches",
    "models",
    "experiments",
    "docs",
    "python/Cargo.toml",
    "python/src",
];
/// Rebuilds this crate alone, and fast: the compiled dependencies are shared.
const OPTIMISATION: &str = "profile.release.package.spinebench.opt-level=0";

/// A block of the guide: a complete file, or a line that goes after another one.
struct Example {
    path: String,
    after: Option<String>,
    text: String,
}

fn examples() -> Vec<Example> {
    let guide =
        std::fs::read_to_string(Path::new(ROOT).join("docs/reference/extending.md")).unwrap();
    let blocks = guide.split("```rust\n").skip(1).map(|rest| rest.split("```").next().unwrap());
    let example = |block: &str| {
        let (head, text) = block.split_once('\n').unwrap();
        let head = head.strip_prefix("// ").expect("a block begins with its path");
        match head.split_once(", after `") {
            Some((path, after)) => {
                let after = Some(after.trim_end_matches('`').to_owned());
                Example { path: path.to_owned(), after, text: text.to_owned() }
            }
            None => Example { path: head.to_owned(), after: None, text: text.to_owned() },
        }
    };
    blocks.map(example).collect()
}

/// Writes a file unless it is the same already: what has not changed is not compiled again.
fn put(path: &Path, bytes: &[u8]) {
    if std::fs::read(path).ok().as_deref() != Some(bytes) {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
}

/// All files at or below `path`.
fn files(path: &Path) -> Vec<PathBuf> {
    if path.is_file() {
        return vec![path.to_owned()];
    }
    std::fs::read_dir(path).unwrap().flatten().flat_map(|entry| files(&entry.path())).collect()
}

/// The sources with the examples in them.
fn extended_tree(tree: &Path) {
    let examples = examples();
    let mut wanted: Vec<(PathBuf, Vec<u8>)> = Vec::new();
    for file in SOURCES.iter().flat_map(|name| files(&Path::new(ROOT).join(name))) {
        let name = file.strip_prefix(ROOT).unwrap();
        let mut bytes = std::fs::read(&file).unwrap();
        for line in examples.iter().filter(|example| Path::new(&example.path) == name) {
            let (text, after) = (
                String::from_utf8(bytes).unwrap(),
                line.after.as_ref().expect("a new file is new"),
            );
            assert_eq!(line.text.trim().lines().count(), 1, "{}: one line", line.path);
            let found: Vec<&str> =
                text.lines().filter(|candidate| candidate.trim() == after).collect();
            assert_eq!(found.len(), 1, "{}: found `{after}` {} times", line.path, found.len());
            bytes = text
                .replace(found[0], &format!("{}\n{}", found[0], line.text.trim_end()))
                .into_bytes();
        }
        wanted.push((name.to_owned(), bytes));
    }
    for file in examples.iter().filter(|example| example.after.is_none()) {
        assert!(
            wanted.iter().all(|(name, _)| name != Path::new(&file.path)),
            "{} is there already",
            file.path
        );
        wanted.push((file.path.clone().into(), file.text.clone().into_bytes()));
    }
    let stale = if tree.exists() { files(tree) } else { Vec::new() };
    for file in stale.iter().filter(|file| wanted.iter().all(|(name, _)| tree.join(name) != **file))
    {
        std::fs::remove_file(file).unwrap();
    }
    wanted.iter().for_each(|(name, bytes)| put(&tree.join(name), bytes));
}

/// Links the compiled dependencies of this build into `target`, so that only this crate is compiled
/// there.
fn share_dependencies(target: &Path) {
    let compiled = Path::new(env!("CARGO_BIN_EXE_spinebench")).parent().unwrap();
    for folder in ["build", "deps", ".fingerprint"] {
        for file in files(&compiled.join(folder)) {
            let name = file.strip_prefix(compiled).unwrap();
            let to = target.join("release").join(name);
            if !name.to_string_lossy().contains("spinebench") && !to.exists() {
                std::fs::create_dir_all(to.parent().unwrap()).unwrap();
                // The folder may lie on another file system.
                std::fs::hard_link(&file, &to)
                    .or_else(|_| std::fs::copy(&file, &to).map(drop))
                    .unwrap();
            }
        }
    }
}

fn cargo(tree: &Path, target: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    let (subcommand, rest) = arguments.split_first().expect("a subcommand");
    command
        .arg(subcommand)
        .args(["--release", "--config", OPTIMISATION])
        .args(rest)
        .current_dir(tree);
    // What the outer build has set for itself is not for this one.
    for (name, _) in std::env::vars_os() {
        let name = name.to_string_lossy().into_owned();
        if (name.starts_with("CARGO_")
            && !["CARGO_HOME", "CARGO_INCREMENTAL"].contains(&name.as_str()))
            || name.starts_with("NEXTEST")
        {
            command.env_remove(name);
        }
    }
    command.env("CARGO_TARGET_DIR", target).output().unwrap()
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// The program with the examples in it.
struct Extended {
    program: PathBuf,
    folder: tempfile::TempDir,
}

impl Extended {
    fn run(&self, arguments: &[&str]) -> String {
        let mut command = Command::new(&self.program);
        let output = command
            .current_dir(self.folder.path())
            .args(arguments)
            .env("SPINEBENCH_CACHE", ".spinebench/cache")
            .output();
        let output = output.unwrap();
        assert!(output.status.success(), "{arguments:?}: {}", told(&output));
        String::from_utf8(output.stdout).unwrap()
    }

    fn read(&self, file: &str) -> String {
        std::fs::read_to_string(self.folder.path().join(file))
            .unwrap_or_else(|error| panic!("{file}: {error}"))
    }

    fn write(&self, file: &str, text: &str) {
        std::fs::write(self.folder.path().join(file), text).unwrap();
    }

    fn assert_says(&self, file: &str, words: &[&str]) {
        let text = self.read(file);
        words
            .iter()
            .for_each(|word| assert!(text.contains(word), "{file}: no `{word}` in\n{text:.4000}"));
    }
}

#[test]
fn the_guides_examples_are_seen_everywhere() {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("extending");
    let tree = target.join("tree");
    extended_tree(&tree);
    share_dependencies(&target);
    let built = cargo(&tree, &target, &["build", "--offline", "--locked", "--bin", "spinebench"]);
    assert!(built.status.success(), "{}", told(&built));
    let program = target
        .join("release")
        .join(Path::new(env!("CARGO_BIN_EXE_spinebench")).file_name().unwrap());
    let extended = Extended { program, folder: tempfile::tempdir().unwrap() };
    command_line_and_schema(&extended);
    effect(&extended);
    experiment(&extended);
    one_policy(&extended);
    let contracts = ["test", "--offline", "--locked", "--test", "contract", "--"];
    let contracts = cargo(
        &tree,
        &target,
        &[
            &contracts[..],
            &["kernels::", "plants::", "policies::", "no_rows_are_an_error", "the_catalogue"],
        ]
        .concat(),
    );
    assert!(contracts.status.success(), "{}", told(&contracts));
}

fn command_line_and_schema(extended: &Extended) {
    let card = extended.run(&["effects", "tracker_scale"]);
    assert!(
        card.contains("the tracker's unit of length is off") && card.contains("scale (ratio"),
        "{card}"
    );
    let schema: serde_json::Value =
        serde_json::from_str(&extended.run(&["schema", "experiment"])).unwrap();
    let definitions = schema["$defs"].to_string();
    for word in [
        "cauchy|",
        "\"fixed_integral\"",
        "FixedIntegralOptions",
        "\"gain\"",
        "\"tracker_scale\"",
        "\"linear_tip\"",
    ] {
        assert!(definitions.contains(word), "no {word} in the definitions of the schema");
    }
    assert!(
        schema["properties"]["figures"].to_string().contains("reach_steps"),
        "{}",
        schema["properties"]["figures"]
    );
    let gain = &schema["$defs"]["FixedIntegralOptions"]["properties"]["gain"];
    assert_eq!(gain["default"], 0.06, "{gain}");
    assert!(extended.run(&["schema", "plant"]).contains("linear_tip"));
    assert!(extended.run(&["schema", "model"]).contains("tracker_scale"));
}

fn effect(extended: &Extended) {
    let nominal = std::fs::read_to_string(Path::new(ROOT).join("models/nominal.yaml")).unwrap();
    extended.write("nominal.yaml", &nominal);
    let scaled = nominal.replace("effects: []", "effects: [{tracker_scale: {scale: 1.5}}]");
    assert_ne!(scaled, nominal);
    extended.write("scaled.yaml", &scaled);
    extended.write(
        "commands.csv",
        "trial,time_s,tendon_1_m,tendon_2_m,tendon_3_m,tendon_4_m\n0,0,0.005,0,-0.005,0\n0,0.2,0.005,0,-0.005,0\n",
    );
    let tip = |model: &str| -> f64 {
        extended.run(&[
            "simulate",
            "--model",
            model,
            "--commands",
            "commands.csv",
            "--out",
            "tips.csv",
            "--static",
        ]);
        let recording = extended.read("tips.csv");
        let mut lines = recording.lines();
        let column = lines.next().unwrap().split(',').position(|name| name == "tip_z_m").unwrap();
        lines.next().unwrap().split(',').nth(column).unwrap().parse().unwrap()
    };
    let ratio = tip("scaled.yaml") / tip("nominal.yaml");
    assert!((ratio - 1.5).abs() < 1e-9, "the effect scales the tip by {ratio}");
}

/// A fifth policy beside one of the paper's, with the new kernel and figure, on the new plant.
fn experiment(extended: &Extended) {
    let smoke = Path::new(ROOT).join("experiments/smoke.yaml");
    let spec = format!(
        "extends: {}\nname: extended\nseeds: 1\nmodel: {{constant_curvature: {{}}}}\nplant: \
         {{linear_tip: {{gain: 4.5}}}}\ngp: {{kernel: cauchy}}\npolicies: {{fixed_integral: \
         {{gain: 0.07}}}}\nmodes: {{open: {{feedback: open}}, closed: {{feedback: closed}}, \
         closed_load: null}}\nruns:\n  gap: null\n  gp_points: []\n  forward: false\n  reach:\n    \
         - {{policies: [a, fixed_integral, pi_patient], modes: [open, closed], gp_points: [20], \
         real_points: [200]}}\n  track: {{policies: [a, fixed_integral], mode: closed, gp_points: \
         20, real_points: null}}\nfigures: [table1, fig8, reach_steps]\nclaims: []\n",
        smoke.display()
    );
    // A mode that the paper's spec has cannot be taken out, only left out of the runs: the new
    // plant takes no load.
    let spec =
        spec.replace(", closed_load: null", ", closed_load: {feedback: closed, effects: []}");
    extended.write("extended.yaml", &spec);
    let plan = extended.run(&["plan", "extended.yaml"]);
    assert!(
        plan.contains("fixed_integral closed") && !plan.contains("fixed_integral open"),
        "{plan}"
    );
    extended.run(&["run", "extended.yaml", "--quiet"]);
    extended.assert_says(
        "results/extended/spec.yaml",
        &["kernel: cauchy", "gain: 0.07", "linear_tip:"],
    );
    extended.assert_says("results/extended/trials.csv", &[",fixed_integral,closed,0,0,"]);
    extended.assert_says("results/extended/summary.csv", &[",fixed_integral,closed,"]);
    extended.assert_says("results/extended/gp.csv", &["cauchy"]);
    extended.assert_says(
        "results/extended/networks.csv",
        &["0,paper,patient,200,", "0,paper,inverse,"],
    );
    extended
        .assert_says("results/extended/table1.md", &["| **fixed integral** |", "| **A** |", "N/A"]);
    extended.assert_says(
        "results/extended/table1.tex",
        &["\nfixed integral & N/A & ", "$\\pi_{patient}$ & 0."],
    );
    extended.assert_says("results/extended/fig8.md", &["| fixed integral |"]);
    for figure in ["table1", "fig8", "reach_steps"] {
        extended.assert_says(&format!("plots/extended/{figure}.svg"), &["fixed integral"]);
        let png =
            std::fs::read(extended.folder.path().join(format!("plots/extended/{figure}.png")))
                .unwrap();
        assert!(png.starts_with(b"\x89PNG"), "{figure}");
    }
}

/// Alone, the policy has a table and figures of its own; it needs no network, and none is trained.
fn one_policy(extended: &Extended) {
    let alone = "extends: extended.yaml\nname: alone\nruns:\n  reach:\n    - {policies: \
                 [fixed_integral], modes: [closed]}\n  track: {policies: [fixed_integral], mode: \
                 closed, gp_points: null}\n";
    extended.write("alone.yaml", alone);
    extended.run(&["run", "alone.yaml", "--quiet", "--set", "policies.fixed_integral.gain=0.05"]);
    let table = extended.read("results/alone/table1.md");
    assert!(table.contains("**fixed integral**") && !table.contains("**A**"), "{table}");
    extended.assert_says("results/alone/table1.tex", &["\nfixed integral & N/A & "]);
    extended.assert_says("plots/alone/table1.svg", &["fixed integral"]);
    assert!(!extended.folder.path().join("results/alone/networks.csv").exists());
}
