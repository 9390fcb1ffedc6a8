//! Where a submission, its copy, its score and a secret may lie.

use crate::cli::program::interrupted::exit_on_interrupt_after;
use crate::cli::{CommandError, CommandResult};
use std::path::{Component, Path, PathBuf};
use tempfile::TempDir;

/// Refuses a place in a submission: its digest covers what is there, and its policy can read it.
pub(super) fn refuse_inside(submission: &Path, key: &str, place: &Path) -> CommandResult {
    let place = real_place(place);
    if place.starts_with(real_place(submission)) {
        refuse!(
            "{key}: found {}, expected a place outside the folder of the submission",
            place.display()
        );
    }
    Ok(())
}

/// A place without links and `..`, whether it exists or not.
pub(super) fn real_place(place: &Path) -> PathBuf {
    let place = std::path::absolute(place).unwrap_or_else(|_| place.to_owned());
    let mut real = PathBuf::new();
    for part in place.components() {
        match part {
            Component::ParentDir => drop(real.pop()),
            part => real.push(part),
        }
        real = real.canonicalize().unwrap_or(real);
    }
    real
}

/// A folder that no other user can read, for the copy of a submission and for experiments with the
/// hidden effects. An interrupt removes it, and ends the process with `words`.
pub(super) fn private_folder(words: &'static str) -> Result<TempDir, CommandError> {
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o700));
    let folder = builder.prefix("spinebench-league-").tempdir().map_err(CommandError::failed)?;
    let place = folder.path().to_owned();
    exit_on_interrupt_after(words, move || {
        // Files that are being written appear while it is removed.
        let is_gone = || std::fs::remove_dir_all(&place).is_ok() || !place.exists();
        for _ in 0..100 {
            if is_gone() {
                break;
            }
        }
    });
    Ok(folder)
}
