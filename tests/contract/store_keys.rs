//! What the key of a stored result depends on: for every file of `src/` and for the packages.

use crate::dependencies::{direct_dependencies, read_sources, sources_of_modules};
use crate::import_graph::{ImportGraph, code};
use spinebench::runner::stages::stage_dependencies;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The files below `src/` by their names.
pub(crate) fn sources() -> BTreeMap<String, String> {
    read_sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src")).unwrap()
}

/// The import graph of these files.
pub(crate) fn graph(files: &BTreeMap<String, String>) -> ImportGraph {
    let manifest =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml")).unwrap();
    let direct = direct_dependencies(&manifest);
    ImportGraph::new("spinebench", files, direct.keys().map(String::as_str)).unwrap()
}

/// The kinds of stage that depend on `file`, by what the program was built with.
fn stages_of(file: &str) -> BTreeSet<&'static str> {
    stage_dependencies()
        .into_iter()
        .filter(|stage| stage.sources.contains(&file))
        .map(|stage| stage.name)
        .collect()
}

const LEARNING: [&str; 6] =
    ["train_forward", "train_inverse", "train_inverse_b", "train_pi_real", "gp_fit", "gp_score"];

/// Stages whose rows are stored.
#[rustfmt::skip]
const ROWS: [&str; 13] = [
    "gap", "gp_score", "gp_fit", "gp_repaired", "gp_moved", "gp_coverage", "gp_leave_one_out", "reach", "track", "response",
    "pace", "monitor", "alarm",
];

#[test]
#[expect(clippy::too_many_lines, reason = "a list of cases")]
fn telling_files_change_the_keys_of_exactly_these_stages() {
    let all: BTreeSet<&str> = stage_dependencies()
        .iter()
        .map(|stage| stage.name)
        .filter(|name| *name != "bench")
        .collect();
    assert_eq!(all.len(), 40);
    let only = |names: &[&'static str]| names.iter().copied().collect::<BTreeSet<_>>();
    // How results lie in the store.
    assert_eq!(&stages_of("runner/graph/codec.rs") - &only(&["bench"]), all);
    assert_eq!(stages_of("rows/experiment.rs"), only(&ROWS));
    // The rod moves in all that build a robot; what is only trained has seen it through its inputs.
    let rod = &stages_of("rod/solver/newton.rs") - &only(&["bench"]);
    for kind in [
        "collect_sim",
        "collect_real",
        "gp_pool",
        "target_pool",
        "waypoints",
        "reach",
        "track",
        "discover",
    ] {
        assert!(rod.contains(kind), "{kind}");
    }
    for kind in LEARNING.into_iter().chain(["gap"]) {
        assert!(!rod.contains(kind), "{kind}");
    }
    assert_eq!(
        stages_of("discovery/fit/gauss_newton.rs"),
        only(&[
            "discover",
            "discover_recorded",
            "baselines",
            "baselines_recorded",
            "identify",
            "diagnose"
        ])
    );
    assert!(stages_of("policies/paper/c.rs").is_superset(&only(&["reach", "track"])));
    assert!(stages_of("policies/paper/c.rs").is_disjoint(&only(&[
        "collect_sim",
        "collect_real",
        "discover",
        "blind_truth"
    ])));
    // A new policy retrains nothing.
    for file in ["policies/paper/c.rs", "policies/mod.rs"] {
        assert!(stages_of(file).is_disjoint(&only(&LEARNING)), "{file}");
    }
    assert!(stages_of("learn/networks/train.rs").is_superset(&only(&[
        "train_forward",
        "train_inverse",
        "train_inverse_b",
        "reach"
    ])));
    // One file of jobs holds both.
    let trials = only(&["reach", "track", "response", "pace", "monitor", "alarm"]);
    assert_eq!(stages_of("tasks/loops/reach.rs"), trials);
    assert_eq!(stages_of("tasks/loops/track.rs"), trials);
    assert_eq!(stages_of("tasks/loops/pace.rs"), only(&["response", "pace"]));
    assert_eq!(stages_of("tasks/monitor.rs"), only(&["monitor", "alarm"]));
    assert_eq!(
        stages_of("plants/hardware/options.rs"),
        only(&["bench"]),
        "a part of the robot's digest, not of stages"
    );
    // Nothing that only plans, draws, publishes or talks.
    for file in sources().keys() {
        let room = file.split('/').next().unwrap();
        let outside = ["report", "cli", "main.rs", "calibration"].contains(&room)
            || [
                "runner/execute/",
                "runner/publish/",
                "runner/store/",
                "runner/slurm/",
                "runner/stages/",
                "runner/campaign.rs",
                "specs/check/",
            ]
            .iter()
            .any(|start| file.starts_with(start));
        assert!(!outside || stages_of(file).is_empty(), "{file}: {:?}", stages_of(file));
    }
}

#[test]
fn a_line_in_any_file_changes_the_keys_of_exactly_the_stages_that_import_it() {
    let files = sources();
    let modules = sources_of_modules(&graph(&files), &files);
    // The program was built with the same.
    for stage in stage_dependencies() {
        let built: BTreeSet<String> =
            stage.sources.iter().map(|&source| source.to_owned()).collect();
        assert_eq!(built, modules[stage.module], "{}", stage.name);
    }
    let before: BTreeMap<&String, String> =
        files.iter().map(|(file, text)| (file, counted(file, text))).collect();
    for (file, text) in &files {
        let line = if file.ends_with(".rs") { "\nconst ONE_MORE_LINE: u8 = 1;\n" } else { "\n" };
        let changed = counted(file, &format!("{text}{line}"));
        assert_ne!(changed, before[file], "{file}: a line of code counts");
        if file.ends_with(".rs") {
            let text = format!("//! A comment.\n{text}\n/* Another. */\n");
            assert_eq!(counted(file, &text), before[file], "{file}: a comment does not count");
        }
        // The keys that change are those of the modules whose sources hold the file, and no other.
        let of_program: BTreeSet<&str> = stage_dependencies()
            .iter()
            .filter(|stage| stage.sources.contains(&file.as_str()))
            .map(|one| one.module)
            .collect();
        let has_jobs =
            |module: &String| stage_dependencies().iter().any(|stage| stage.module == module);
        let of_graph =
            modules.iter().filter(|(module, sources)| has_jobs(module) && sources.contains(file));
        let of_graph = of_graph.map(|(module, _)| module.as_str());
        assert_eq!(of_program, of_graph.collect(), "{file}");
    }
}

fn counted(file: &str, text: &str) -> String {
    if file.ends_with(".rs") { code(text).unwrap() } else { text.to_owned() }
}

/// A second, naive route to the same closure: a file that names, anywhere in its text, a type that
/// a file of the closure alone defines must find that file in the closure.
#[test]
fn types_named_in_the_text_of_a_closure_are_defined_in_it() {
    let files = sources();
    let defined = definitions(&files);
    for (module, closure) in sources_of_modules(&graph(&files), &files) {
        for file in &closure {
            let text = code(&files[file]).unwrap_or_default();
            let own: BTreeSet<&str> =
                text.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
            // Names in a file that only passes them on, or that a facade re-exports, are not used
            // by it.
            if file.ends_with("/mod.rs") {
                continue;
            }
            for (name, definer) in defined.iter().filter(|(name, _)| own.contains(name.as_str())) {
                let bench = definer.starts_with("plants/hardware/") && module != "bench";
                assert!(
                    bench || closure.contains(definer),
                    "{module}: {file} names {name} of {definer}"
                );
            }
        }
    }
}

/// Names of long public types that one file alone defines and that no other crate has.
fn definitions(files: &BTreeMap<String, String>) -> BTreeMap<String, String> {
    let mut found: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (file, text) in files.iter().filter(|(file, _)| file.ends_with(".rs")) {
        for line in code(text).unwrap().split("pub ").skip(1) {
            let mut words = line.split_whitespace();
            if ["struct", "enum", "trait"].contains(&words.next().unwrap_or_default()) {
                let name = words.next().unwrap_or_default();
                if name.len() >= 8 && name.chars().skip(1).any(char::is_uppercase) {
                    found.entry(name.to_owned()).or_default().insert(file.clone());
                }
            }
        }
    }
    let single = |(name, files): (String, BTreeSet<String>)| {
        (files.len() == 1).then(|| (name, files.into_iter().next().unwrap()))
    };
    found.into_iter().filter_map(single).collect()
}

#[test]
fn packages_come_from_the_lock_file() {
    let stages = stage_dependencies();
    let packages = |kind: &str| -> BTreeSet<&str> {
        let stage = stages.iter().find(|stage| stage.name == kind).unwrap();
        stage.packages.iter().map(|package| package.split(' ').next().unwrap()).collect()
    };
    for kind in ["collect_sim", "gp_pool", "reach", "blind_truth"] {
        let found = packages(kind);
        for package in ["rand", "rand_core", "rand_chacha", "rand_distr", "libm"] {
            assert!(found.contains(package), "{kind}: {package}");
        }
    }
    assert!(packages("gp_fit").contains("faer") && packages("train_inverse").contains("serde"));
    for package in ["plotters", "clap", "indicatif", "maud"] {
        assert!(
            stages
                .iter()
                .all(|stage| stage.name == "bench" || !packages(stage.name).contains(package)),
            "{package}"
        );
    }
    let exact = |package: &&&str| package.split(' ').count() == 3;
    assert!(
        stages.iter().all(|stage| stage.packages.iter().all(|package| exact(&package))),
        "name, version, checksum"
    );
}

#[test]
fn re_exports_attributes_macros_and_impls_are_followed() {
    let files: BTreeMap<String, String> = [
        ("lib.rs", "pub mod a; pub mod b; mod c; mod d; mod e; mod f; mod tests_only;"),
        (
            "a.rs",
            "use crate::b::Name; use crate::b as short; fn f() { short::inner::call!(); } \
                  struct S { #[serde(with = \"crate::e\")] x: u8 }",
        ),
        ("b/mod.rs", "mod inner; mod other; pub use inner::Name; pub use other::Unused;"),
        ("b/inner.rs", "pub struct Name; fn g() { format!(\"{}\", crate::f::value()); }"),
        ("b/other.rs", "pub struct Unused;"),
        ("c.rs", "impl Clone for crate::b::Name {}"),
        ("d.rs", "impl crate::b::Unused { fn h() {} }"),
        ("e.rs", "pub fn serialize() {}"),
        (
            "f.rs",
            "pub fn value() -> u8 { rand::random() } #[cfg(test)] mod tests { use crate::d; \
                  }",
        ),
        ("tests_only.rs", ""),
    ]
    .map(|(file, text)| (file.to_owned(), text.to_owned()))
    .into();
    let graph = ImportGraph::new("spinebench", &files, ["rand"]).unwrap();
    let closure = graph.closure(["a.rs"], |_| false);
    let found: Vec<&str> = closure.iter().map(String::as_str).collect();
    assert_eq!(found, ["a.rs", "b/inner.rs", "c.rs", "e.rs", "f.rs"]);
    assert!(graph.crates("f.rs").contains("rand"));
}
