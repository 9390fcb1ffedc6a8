//! What a run has published, for tests that compare runs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// All files under `results/` and `plots/` below a folder, by their path, except those that hold clocks.
pub(crate) fn published(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.join("results"), folder.join("plots")];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if !path.ends_with("manifest.yaml") && !path.ends_with("stages.csv") {
                found.insert(path.strip_prefix(folder).unwrap().to_owned(), std::fs::read(&path).unwrap());
            }
        }
    }
    found
}
