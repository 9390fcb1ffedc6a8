//! Whole files in and out.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::DataError;

/// Reads a whole file.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, DataError> {
    fs::read(path).map_err(|error| DataError::Read { file: path.to_owned(), reason: error.to_string() })
}

/// Writes a whole file or nothing: the bytes go to a neighbour that then takes the name, so that a reader never
/// meets half a file and a failure leaves the old one. Missing folders are made.
///
/// # Errors
/// [`DataError::Write`] when the folder cannot be made or the file not written.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), DataError> {
    let neighbour = neighbour_of(path);
    write_and_rename(path, &neighbour, bytes).map_err(|error| {
        // The neighbour may not exist; what matters is the first error.
        let _ = fs::remove_file(&neighbour);
        DataError::Write { file: path.to_owned(), reason: error.to_string() }
    })
}

/// Writes whole files that belong together: all of them are on the disk before the first takes its name, so that a full
/// disk leaves the old ones all as they were.
///
/// # Errors
/// [`DataError::Write`] for the first file that cannot be written.
pub fn write_together<'a>(files: impl Iterator<Item = (PathBuf, &'a [u8])>) -> Result<(), DataError> {
    let mut written = Vec::new();
    let mut outcome = Ok(());
    for (path, bytes) in files {
        let neighbour = neighbour_of(&path);
        outcome = write_neighbour(&path, &neighbour, bytes);
        written.push((path, neighbour));
        if outcome.is_err() {
            break;
        }
    }
    for (path, neighbour) in &written {
        outcome = outcome.and_then(|()| fs::rename(neighbour, path));
        if let Err(error) = &outcome {
            // Those that have taken their names are gone; what matters is the first error.
            written.iter().for_each(|(_, neighbour)| drop(fs::remove_file(neighbour)));
            return Err(DataError::Write { file: path.clone(), reason: error.to_string() });
        }
    }
    Ok(())
}

fn write_and_rename(path: &Path, neighbour: &Path, bytes: &[u8]) -> std::io::Result<()> {
    write_neighbour(path, neighbour, bytes)?;
    fs::rename(neighbour, path)
}

fn write_neighbour(path: &Path, neighbour: &Path, bytes: &[u8]) -> std::io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let mut file = fs::File::create(neighbour)?;
    file.write_all(bytes)?;
    file.sync_all()
}

/// A hidden name in the same folder (renaming across file systems is not atomic), distinct for each process.
fn neighbour_of(path: &Path) -> PathBuf {
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

    #[test]
    fn of_files_that_belong_together_all_are_new_or_none() {
        let folder = tempfile::tempdir().unwrap();
        let (one, two) = (folder.path().join("one"), folder.path().join("two"));
        write_together([(one.clone(), &b"1"[..]), (two.clone(), b"2")].into_iter()).unwrap();
        // The second's folder cannot be made: a file stands in its place.
        let bad = folder.path().join("one/three");
        let files = [(two.clone(), &b"9"[..]), (bad.clone(), b"3")];
        let Err(DataError::Write { file, .. }) = write_together(files.into_iter()) else { panic!("written") };
        assert_eq!((fs::read(&one).unwrap(), fs::read(&two).unwrap()), (b"1".to_vec(), b"2".to_vec()));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "{}", file.display());
    }
}
