//! What a stage depends on: the sources that its job imports and the packages that these name.
//! Shared by the build script, which makes digests of it, and by the tests of the stores' keys.

use super::import_graph::ImportGraph;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The folder of jobs: each file is the root of the stages that it defines.
const JOBS: &str = "runner/jobs/";
/// How results are laid out in the store: every stage depends on it.
const CODEC: &str = "runner/graph/codec.rs";
/// What only robots on a bench and rehearsals of them run: in the digest of such a robot, not of
/// every stage that may build one.
const BENCH: &str = "plants/hardware/";

/// The sources of a stage or of a robot on a bench, by the name of its module.
pub(crate) fn sources_of_modules(
    graph: &ImportGraph,
    files: &BTreeMap<String, String>,
) -> BTreeMap<String, BTreeSet<String>> {
    let mut modules = BTreeMap::new();
    for job in files.keys().filter(|file| file.starts_with(JOBS) && !file.ends_with("/mod.rs")) {
        let module = format!("spinebench::{}", job.trim_end_matches(".rs").replace('/', "::"));
        modules
            .insert(module, graph.closure([job.as_str(), CODEC], |file| file.starts_with(BENCH)));
    }
    let bench = files
        .keys()
        .map(String::as_str)
        .filter(|file| file.starts_with(BENCH) && file.ends_with(".rs"));
    modules.insert("bench".to_owned(), graph.closure(bench, |_| false));
    modules
}

/// Every file below `folder` by its path from there.
pub(crate) fn read_sources(folder: &Path) -> std::io::Result<BTreeMap<String, String>> {
    fn descend(
        folder: &Path,
        root: &Path,
        files: &mut BTreeMap<String, String>,
    ) -> std::io::Result<()> {
        for entry in std::fs::read_dir(folder)? {
            let path = entry?.path();
            if path.is_dir() {
                descend(&path, root, files)?;
            } else if let Ok(text) = std::fs::read_to_string(&path) {
                let name =
                    path.strip_prefix(root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
                files.insert(name, text);
            }
        }
        Ok(())
    }
    let mut files = BTreeMap::new();
    descend(folder, folder, &mut files)?;
    Ok(files)
}

/// The library names of the crate's dependencies with the names of their packages, from the text of
/// `Cargo.toml`.
pub(crate) fn direct_dependencies(manifest: &str) -> BTreeMap<String, String> {
    let section = manifest.split("\n[dependencies]\n").nth(1).unwrap_or_default();
    let mut found = BTreeMap::new();
    for line in section.lines().take_while(|line| !line.starts_with('[')) {
        if let Some((name, value)) =
            line.split_once(" = ").filter(|(name, _)| !name.starts_with('#'))
        {
            let renamed =
                value.split_once("package = \"").and_then(|(_, rest)| rest.split('"').next());
            found.insert(name.replace('-', "_"), renamed.unwrap_or(name).to_owned());
        }
    }
    found
}
