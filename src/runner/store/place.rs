//! Where the store lies.

use std::path::{Path, PathBuf};

/// Names the folder of the store.
const VARIABLE: &str = "SPINEBENCH_CACHE";

/// The folder of the store: `given`, else what `SPINEBENCH_CACHE` names, else `.spinebench/cache`
/// of the checkout around the current folder, else a folder among the user's caches.
pub fn store_folder(given: Option<&Path>) -> PathBuf {
    let set = std::env::var_os(VARIABLE).filter(|folder| !folder.is_empty()).map(PathBuf::from);
    let named = given.map(Path::to_owned).or(set);
    named.unwrap_or_else(|| of_folder(&std::env::current_dir().unwrap_or_default()))
}

/// That of the nearest folder from `folder` upwards that is a checkout or holds a store, else that
/// of the user.
fn of_folder(folder: &Path) -> PathBuf {
    let holds =
        |folder: &&Path| folder.join(".spinebench").is_dir() || folder.join(".git").exists();
    match (folder.ancestors().find(holds), dirs::cache_dir()) {
        (Some(checkout), _) => checkout.join(".spinebench/cache"),
        (None, Some(caches)) => caches.join("spinebench"),
        (None, None) => folder.join(".spinebench/cache"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_checkout_has_one_store_for_all_its_folders() {
        let checkout = tempfile::tempdir().unwrap();
        let inside = checkout.path().join("experiments/sweeps");
        std::fs::create_dir_all(&inside).unwrap();
        assert!(!of_folder(&inside).starts_with(checkout.path()), "{:?}", of_folder(&inside));
        std::fs::create_dir(checkout.path().join(".git")).unwrap();
        assert_eq!(of_folder(&inside), checkout.path().join(".spinebench/cache"));
        std::fs::create_dir(inside.join(".spinebench")).unwrap();
        assert_eq!(of_folder(&inside), inside.join(".spinebench/cache"));
    }
}
