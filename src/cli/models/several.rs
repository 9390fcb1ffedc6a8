//! Several recordings of one robot on the command line.

use crate::cli::{CommandError, CommandResult};
use spinebench::data::Recording;
use spinebench::data::recording::RecordingMismatch;
use std::path::PathBuf;

/// Refuses a recording that is given twice: its copy would appear in the held-out trials.
pub(super) fn refuse_twins(files: &[PathBuf], parts: &[Recording]) -> CommandResult {
    for (k, part) in parts.iter().enumerate() {
        if let Some(first) =
            parts[..k].iter().position(|earlier| earlier.holds(part) || part.holds(earlier))
        {
            let [again, first] = [k, first].map(|index| files[index].display());
            refuse!("{again}: found the trials of {first} again, expected another recording");
        }
    }
    Ok(())
}

/// A recording that cannot be concatenated with those before it.
pub(super) fn mismatch(files: &[PathBuf], error: &RecordingMismatch) -> CommandError {
    CommandError::BadInput(format!("{}, line 1: {error}", files[error.index].display()))
}
