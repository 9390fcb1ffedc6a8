//! Several recordings of one robot on the command line.

use crate::cli::{CommandError, CommandResult};
use spinebench::data::Recording;
use spinebench::data::recording::RecordingMismatch;
use spinebench::runner::Progress;
use spinebench::tasks::are_at_rest;
use std::path::{Path, PathBuf};

/// Refuses a recording that is given twice: its copy would appear in the held-out trials.
pub(super) fn refuse_twins(files: &[PathBuf], parts: &[Recording]) -> CommandResult {
    for (k, part) in parts.iter().enumerate() {
        if let Some(first) =
            parts[..k].iter().position(|earlier| earlier.holds(part) || part.holds(earlier))
        {
            let [again, first] = [k, first].map(|index| files[index].display());
            refuse!("{again}: found the same trials as in {first}, expected another recording");
        }
    }
    Ok(())
}

/// Whether these recordings are of poses at rest, because `--static` says so or because their rows
/// are marked; the latter is told.
pub(crate) fn poses_at_rest<'a>(
    option: bool,
    recordings: impl IntoIterator<Item = (&'a Path, &'a Recording)>,
    progress: &Progress,
) -> Result<bool, CommandError> {
    let at_rest = are_at_rest(option, recordings).map_err(CommandError::bad_input)?;
    if at_rest && !option {
        progress.notice("all rows are marked as poses at rest (`at_rest`): read as with --static");
    }
    Ok(at_rest)
}

/// A recording that cannot be concatenated with those before it.
pub(super) fn mismatch(files: &[PathBuf], error: &RecordingMismatch) -> CommandError {
    CommandError::BadInput(format!("{}, line 1: {error}", files[error.index].display()))
}
