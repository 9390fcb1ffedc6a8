//! What a run has published, for tests that compare runs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// All files under `results/` and `plots/` below a folder, by their path, except those that hold
/// clocks.
pub(crate) fn published(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.join("results"), folder.join("plots")];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if !path.ends_with("manifest.yaml") && !path.ends_with("stages.csv") {
                found.insert(
                    path.strip_prefix(folder).unwrap().to_owned(),
                    std::fs::read(&path).unwrap(),
                );
            }
        }
    }
    found
}

/// Fails with the names of files that one has and the other has not or has otherwise; bytes tell a
/// person nothing.
pub(crate) fn assert_same(
    found: &BTreeMap<PathBuf, Vec<u8>>,
    expected: &BTreeMap<PathBuf, Vec<u8>>,
    when: &str,
) {
    let names = found.keys().chain(expected.keys());
    let other: Vec<&PathBuf> =
        names.filter(|name| found.get(*name) != expected.get(*name)).collect();
    assert!(other.is_empty(), "{when}: {other:?}");
}
