//! Reading of whole files, and the names under which they are written.

use std::fs;
use std::path::{Path, PathBuf};

use super::DataError;

/// Reads a whole file.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, DataError> {
    fs::read(path).map_err(|error| DataError::Read { file: path.to_owned(), reason: error.to_string() })
}

/// Creates a file and its folders.
pub(super) fn create(path: &Path) -> std::io::Result<fs::File> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    fs::File::create(path)
}

/// A hidden name in the same folder (renaming across file systems is not atomic), distinct for each process.
pub(super) fn temporary_path(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}.tmp", std::process::id()))
}
