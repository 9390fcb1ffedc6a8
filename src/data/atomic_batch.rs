//! Atomic replacement of files, one or several together.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use super::DataError;
use super::file::{create, temporary_path};

/// Writes a file atomically: the bytes go to a temporary file that is then renamed. A failure
/// leaves the old file. Missing folders are created.
///
/// # Errors
/// [`DataError::Write`] when the folder cannot be made or the file not written.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), DataError> {
    write_atomic_batch(std::iter::once((path.to_owned(), bytes)))
}

/// Writes a set of files atomically: all are on disk under temporary names before the first is
/// renamed, so that a full disk leaves the old files unchanged. Temporary files of writers that
/// were killed are removed.
///
/// # Errors
/// [`DataError::Write`] for the first file that cannot be written.
pub fn write_atomic_batch<'a>(
    files: impl Iterator<Item = (PathBuf, &'a [u8])>,
) -> Result<(), DataError> {
    let mut staged = StagedFiles::default();
    for (path, bytes) in files {
        staged.add(path, bytes)?;
    }
    staged.commit()
}

/// Temporary files beside their targets; those that were not renamed are removed on drop.
#[derive(Default)]
struct StagedFiles {
    files: Vec<StagedFile>,
}

struct StagedFile {
    path: PathBuf,
    temporary: PathBuf,
    /// Locked while its writer lives.
    _file: File,
}

impl StagedFiles {
    fn add(&mut self, path: PathBuf, bytes: &[u8]) -> Result<(), DataError> {
        let temporary = temporary_path(&path);
        let written = (|| {
            let mut file = create(&temporary)?;
            // On a file system without locks, stale files stay.
            let _ = file.try_lock();
            file.write_all(bytes)?;
            file.sync_all().map(|()| file)
        })();
        match written {
            Ok(file) => self.files.push(StagedFile { path, temporary, _file: file }),
            Err(error) => {
                // It may not exist; what matters is the first error.
                let _ = fs::remove_file(&temporary);
                return Err(refused(&path, &error));
            }
        }
        Ok(())
    }

    fn commit(self) -> Result<(), DataError> {
        for file in &self.files {
            fs::rename(&file.temporary, &file.path).map_err(|error| refused(&file.path, &error))?;
        }
        let folders: BTreeSet<&Path> =
            self.files.iter().filter_map(|file| file.path.parent()).collect();
        let names: BTreeSet<&Path> = self.files.iter().map(|file| file.path.as_path()).collect();
        folders.into_iter().for_each(|folder| remove_stale(folder, &names));
        Ok(())
    }
}

impl Drop for StagedFiles {
    fn drop(&mut self) {
        // Renamed files no longer exist under this name.
        self.files.iter().for_each(|file| drop(fs::remove_file(&file.temporary)));
    }
}

/// Removes temporary files of these targets whose writers have ended.
fn remove_stale(folder: &Path, names: &BTreeSet<&Path>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let temporary = entry.path();
        let of_ours = target_of(&temporary).is_some_and(|path| names.contains(path.as_path()));
        if of_ours && File::open(&temporary).is_ok_and(|file| file.try_lock().is_ok()) {
            let _ = fs::remove_file(&temporary); // somebody else may have been quicker
        }
    }
}

/// The target of a temporary file: `.NAME.PROCESS.tmp`.
fn target_of(temporary: &Path) -> Option<PathBuf> {
    let name = temporary.file_name()?.to_str()?;
    let (name, process) = name.strip_prefix('.')?.strip_suffix(".tmp")?.rsplit_once('.')?;
    process.bytes().all(|byte| byte.is_ascii_digit()).then(|| temporary.with_file_name(name))
}

fn refused(path: &Path, error: &io::Error) -> DataError {
    DataError::Write { file: path.to_owned(), reason: error.to_string() }
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
        assert!(matches!(
            write_atomic(&folder.path().join("taken"), b"x"),
            Err(DataError::Write { .. })
        ));
        let mut names: Vec<_> =
            fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
        names.sort();
        assert_eq!(names, ["new", "taken"]);
    }

    #[test]
    fn all_are_new_or_none() {
        let folder = tempfile::tempdir().unwrap();
        let (one, two) = (folder.path().join("one"), folder.path().join("two"));
        write_atomic_batch([(one.clone(), &b"1"[..]), (two.clone(), b"2")].into_iter()).unwrap();
        // The second's folder cannot be made: a file stands in its place.
        let bad = folder.path().join("one/three");
        let files = [(two.clone(), &b"9"[..]), (bad.clone(), b"3")];
        let Err(DataError::Write { file, .. }) = write_atomic_batch(files.into_iter()) else {
            panic!("written")
        };
        assert_eq!(
            (file, fs::read(&one).unwrap(), fs::read(&two).unwrap()),
            (bad, b"1".to_vec(), b"2".to_vec())
        );
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    #[test]
    fn what_the_dead_left_goes_and_what_the_living_write_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.csv");
        let [dead, living, other] =
            ["7", "8", "x"].map(|who| folder.path().join(format!(".rows.csv.{who}.tmp")));
        [&dead, &other].iter().for_each(|file| fs::write(file, "half").unwrap());
        let held = File::create(&living).unwrap();
        held.lock().unwrap();
        write_atomic_batch([(path.clone(), &b"1"[..])].into_iter()).unwrap();
        assert_eq!(
            [&path, &dead, &living, &other].map(|file| file.exists()),
            [true, false, true, true]
        );
    }
}
