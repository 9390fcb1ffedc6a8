//! The digest of the code of a stage: of the sources that its job imports, directly or through
//! others, and of the packages that these name. It is part of the stage's key, so that a result of
//! other code is never taken for one of this code. The build script derives the imports
//! (`build/import_graph.rs`).

use super::digest::Digest;

include!(concat!(env!("OUT_DIR"), "/sources.rs"));

/// The code behind the jobs of one module.
struct CodeOfModule {
    module: &'static str,
    /// Places in [`SOURCES`].
    sources: &'static [usize],
    /// Packages with version and checksum.
    packages: &'static [&'static str],
}

/// What the code of a robot on a bench is: part of the digest of such a robot, not of all stages.
pub(crate) const BENCH: &str = "bench";

/// The digest of the code behind the jobs of `module`, named as by `module_path!()`.
pub(crate) fn of_module(module: &str) -> Digest {
    let code = MODULES.iter().find(|code| code.module == module);
    let code = code.unwrap_or_else(|| {
        panic!("{module}: found a stage outside of src/runner/jobs, expected one within")
    });
    let mut hasher = blake3::Hasher::new();
    for &source in code.sources {
        let (name, text) = SOURCES[source];
        hasher.update(name.as_bytes());
        for half in text {
            hasher.update(&half.to_le_bytes());
        }
    }
    for package in code.packages {
        hasher.update(package.as_bytes());
    }
    Digest::from(hasher.finalize())
}

/// The digest of the code that drives a robot on a bench, or a rehearsal of one.
pub(crate) fn of_bench() -> Digest {
    of_module(BENCH)
}

/// The sources below `src/` and the packages behind the jobs of `module`; nothing for a module
/// without jobs.
pub(crate) fn dependencies(module: &str) -> (Vec<&'static str>, &'static [&'static str]) {
    let code = MODULES.iter().find(|code| code.module == module);
    let sources = code.map(|code| code.sources.iter().map(|&source| SOURCES[source].0).collect());
    (sources.unwrap_or_default(), code.map_or(&[], |code| code.packages))
}
