//! Reading of whole files, and the names under which they are written.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::DataError;

/// Reads a whole file.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, DataError> {
    fs::read(path).map_err(|error| {
        let reason =
            if error.kind() == ErrorKind::NotFound { missing(path) } else { error.to_string() };
        DataError::Read { file: path.to_owned(), reason }
    })
}

/// Where a file that is not there was searched for.
fn missing(path: &Path) -> String {
    let folder =
        path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match folder.canonicalize() {
        Ok(place) => format!("found no such file in {}", place.display()),
        Err(_) => format!("found no folder {}", folder.display()),
    }
}

/// Creates a file and its folders.
pub(super) fn create(path: &Path) -> std::io::Result<fs::File> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    fs::File::create(path)
}

/// A hidden name in the same folder (renaming across file systems is not atomic), distinct for each
/// process.
pub(super) fn temporary_path(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}.tmp", std::process::id()))
}
