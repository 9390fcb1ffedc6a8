//! Reading and atomic writing of whole files.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::DataError;

/// Reads a whole file.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, DataError> {
    fs::read(path).map_err(|error| DataError::Read { file: path.to_owned(), reason: error.to_string() })
}

/// Writes a file atomically: the bytes go to a temporary file that is then renamed. A failure leaves the old file.
/// Missing folders are created.
///
/// # Errors
/// [`DataError::Write`] when the folder cannot be made or the file not written.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), DataError> {
    let temporary = temporary_path(path);
    write_and_rename(path, &temporary, bytes).map_err(|error| {
        // The temporary file may not exist; what matters is the first error.
        let _ = fs::remove_file(&temporary);
        DataError::Write { file: path.to_owned(), reason: error.to_string() }
    })
}

fn write_and_rename(path: &Path, temporary: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut file = create(temporary)?;
    file.write_all(bytes)?;
    file.sync_all()?;
    drop(file);
    fs::rename(temporary, path)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_nothing_and_a_good_one_only_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/rows.csv");
        write_atomic(&path, b"a\n1\n").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"a\n1\n");
        // A folder stands where the file should go: the rename fails.
        fs::create_dir(folder.path().join("taken")).unwrap();
        assert!(matches!(write_atomic(&folder.path().join("taken"), b"x"), Err(DataError::Write { .. })));
        let mut names: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
        names.sort();
        assert_eq!(names, ["new", "taken"]);
    }
}
