//! Hands digests of sources and packages to the program: a stored result is believed only by the code that computed it
//! (`src/runner/graph/source_digest.rs`).

#[path = "build/dependencies.rs"]
mod dependencies;
#[path = "build/import_graph.rs"]
mod import_graph;

use cargo_lock::{Lockfile, Package};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

fn main() {
    for path in ["src", "build", "Cargo.lock", "Cargo.toml"] {
        println!("cargo:rerun-if-changed={path}");
    }
    println!("cargo:rustc-env=SPINEBENCH_REVISION={}", revision());
    let files = dependencies::read_sources(Path::new("src")).expect("the sources can be read");
    let manifest = fs::read_to_string("Cargo.toml").expect("the manifest can be read");
    let direct = dependencies::direct_dependencies(&manifest);
    let graph =
        import_graph::ImportGraph::new("spinebench", &files, direct.keys().map(String::as_str));
    let graph = graph.unwrap_or_else(|error| panic!("{error}"));
    // Without its lock file, as a dependency of another crate, the program's packages are not known.
    let lock = Lockfile::load("Cargo.lock").ok();
    let mut text = "const SOURCES: &[(&str, [u64; 2])] = &[\n".to_owned();
    let mut places: BTreeMap<&str, usize> = BTreeMap::new();
    for (place, (name, source)) in files.iter().enumerate() {
        let code = if name.ends_with(".rs") {
            import_graph::code(source).expect("a parsed source")
        } else {
            source.clone()
        };
        let _ = writeln!(text, "    ({name:?}, {:?}),", digest(&code));
        places.insert(name, place);
    }
    text += "];\nconst MODULES: &[CodeOfModule] = &[\n";
    for (module, sources) in dependencies::sources_of_modules(&graph, &files) {
        let crates: BTreeSet<&str> =
            sources.iter().flat_map(|source| graph.crates(source)).map(String::as_str).collect();
        let named = crates.into_iter().filter_map(|name| direct.get(name));
        let packages: Vec<String> = lock
            .as_ref()
            .map(|lock| packages(lock, named).into_iter().collect())
            .unwrap_or_default();
        let sources: Vec<usize> =
            sources.iter().filter_map(|source| places.get(source.as_str()).copied()).collect();
        let _ = writeln!(
            text,
            "    CodeOfModule {{ module: {module:?}, sources: &{sources:?}, packages: &{packages:?} }},"
        );
    }
    text += "];\n";
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo names the folder"));
    fs::write(out.join("sources.rs"), text).expect("cargo's folder can be written");
}

/// The revision as the local part of a version, `+489860f7`, with `.modified` where the sources were
/// changed since; empty outside the repository. It is looked up when the sources change, and a commit
/// alone compiles nothing anew.
fn revision() -> String {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).output().ok()?;
        let text = output.status.success().then(|| String::from_utf8(output.stdout).ok())??;
        Some(text.trim().to_owned())
    };
    // Sources that were copied into another repository have no revision there.
    let tracked = git(&["ls-files", "--error-unmatch", "build.rs"]);
    let Some(revision) = tracked.and_then(|_| git(&["rev-parse", "--short=8", "HEAD"])) else {
        return String::new();
    };
    let sources = ["src", "build", "build.rs", "Cargo.toml", "Cargo.lock"];
    let status = ["status", "--porcelain", "--untracked-files=no", "--"];
    let changes = git(&[&status[..], &sources].concat()).unwrap_or_default();
    format!("+{revision}{}", if changes.is_empty() { "" } else { ".modified" })
}

/// The named dependencies of the crate and all that they depend on, with version and checksum.
fn packages<'a>(lock: &Lockfile, named: impl Iterator<Item = &'a String>) -> BTreeSet<String> {
    let own = lock.packages.iter().find(|package| package.name.as_str() == env!("CARGO_PKG_NAME"));
    let of = |package: &Package, name: Option<&str>| -> Vec<&Package> {
        let wanted = package
            .dependencies
            .iter()
            .filter(|one| name.is_none_or(|name| one.name.as_str() == name));
        let matches = |one: &cargo_lock::Dependency| {
            lock.packages
                .iter()
                .find(|package| package.name == one.name && package.version == one.version)
        };
        wanted.filter_map(matches).collect()
    };
    let mut next: Vec<&Package> =
        named.flat_map(|name| own.map(|own| of(own, Some(name))).unwrap_or_default()).collect();
    let mut found = BTreeSet::new();
    while let Some(package) = next.pop() {
        let checksum = package.checksum.as_ref().map(ToString::to_string).unwrap_or_default();
        if found.insert(format!("{} {} {checksum}", package.name, package.version)) {
            next.extend(of(package, None));
        }
    }
    found
}

/// Fowler, Noll and Vo's FNV-1a, 128 bits: tells sources apart and guards against nobody.
fn digest(text: &str) -> [u64; 2] {
    let step = |hash: u128, byte: u8| (hash ^ u128::from(byte)).wrapping_mul((1 << 88) + 0x13b);
    let hash = text.bytes().fold(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d, step);
    [(hash >> 64) as u64, hash as u64]
}
