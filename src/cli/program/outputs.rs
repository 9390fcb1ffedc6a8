//! Checks of outputs before the work: the folder takes files, there is room, the name fits what is
//! written.

use crate::cli::{CommandError, CommandResult};
use spinebench::data::Recording;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// Bytes of a row of a recording in full precision, at most.
const ROW_BYTES: usize = 1000;
/// Bytes of a report with its figures and tables, at most.
pub(crate) const REPORT_BYTES: usize = 4 << 20;
/// Bytes of a model or plant file, at most.
const YAML_BYTES: usize = 64 << 10;

/// Checks that a recording of `rows` rows can be written to `file`.
///
/// # Errors
/// [`CommandError::BadInput`] for another ending than `.csv` and `.parquet` and for a place that
/// takes no file, [`CommandError::Failed`] for a full disk.
pub(crate) fn check_recording(file: &Path, rows: usize) -> CommandResult {
    Recording::check_name(file).map_err(CommandError::bad_input)?;
    check_file(file, rows * ROW_BYTES)
}

/// Checks that a YAML file can be written to `file`. Errors as [`check_recording`].
pub(crate) fn check_yaml(file: &Path) -> CommandResult {
    check_ending(file, &["yaml", "yml"])?;
    check_file(file, YAML_BYTES)
}

/// Refuses an ending that is none of these; none is fine.
pub(crate) fn check_ending(file: &Path, endings: &[&str]) -> CommandResult {
    let ending = file.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    if let Some(other) = ending.filter(|ending| !endings.contains(&ending.as_str())) {
        refuse!("{}: found the ending `.{other}`, expected `.{}`", file.display(), endings[0]);
    }
    Ok(())
}

/// Checks that a file of `bytes` bytes can be written to `file`. Errors as [`check_folder`].
pub(crate) fn check_file(file: &Path, bytes: usize) -> CommandResult {
    if file.is_dir() {
        refuse!("{}: found a folder, expected the name of a file", file.display());
    }
    let folder =
        file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    probe(folder, bytes)
        .map_err(|error| write_error(file, &error, "a file in a folder that can be written to"))
}

/// Checks that files of `bytes` bytes together can be written to `folder`, which need not exist.
/// Leaves nothing behind.
///
/// # Errors
/// [`CommandError::BadInput`] for a folder that cannot be made or written to,
/// [`CommandError::Failed`] for a full disk.
pub(crate) fn check_folder(folder: &Path, bytes: usize) -> CommandResult {
    probe(folder, bytes).map_err(|error| write_error(folder, &error, "a writable folder"))
}

fn write_error(place: &Path, error: &io::Error, expected: &str) -> CommandError {
    let place = place.display();
    match error.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            CommandError::Failed(format!("{place}: cannot write: {error}; nothing was computed"))
        }
        _ => CommandError::BadInput(format!("{place}: found {error}, expected {expected}")),
    }
}

/// Writes `bytes` bytes to a new file in `folder` and removes everything again. Quotas and file
/// systems that are mounted without the right to write show in no other way.
fn probe(folder: &Path, bytes: usize) -> io::Result<()> {
    let missing: Vec<PathBuf> = folder
        .ancestors()
        .take_while(|place| !place.as_os_str().is_empty() && !place.exists())
        .map(Path::to_owned)
        .collect();
    let result = write_probe(folder, bytes);
    // A folder in which another process has begun to write stays.
    missing.iter().for_each(|made| drop(std::fs::remove_dir(made)));
    result
}

fn write_probe(folder: &Path, bytes: usize) -> io::Result<()> {
    let probe = folder.join(format!(".spinebench-{}", std::process::id()));
    let mut tries = 0;
    let mut file = loop {
        std::fs::create_dir_all(folder)?;
        match std::fs::File::create(&probe) {
            // Another process has removed the folder that it had made for its own probe.
            Err(error) if error.kind() == io::ErrorKind::NotFound && tries < 10 => tries += 1,
            made => break made?,
        }
    };
    let block = [0x5a; 1 << 16];
    let written = (0..bytes.div_ceil(block.len()))
        .try_for_each(|_| file.write_all(&block))
        .and_then(|()| file.sync_all());
    // A process with the same id on another machine may have removed the file already.
    let removed = std::fs::remove_file(&probe)
        .or_else(|error| if probe.exists() { Err(error) } else { Ok(()) });
    written.and(removed)
}
