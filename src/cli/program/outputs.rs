//! Checks of outputs before the work: the folder takes files, there is room, the name fits what is
//! written.

use crate::cli::{CommandError, CommandResult};
use spinebench::data::Recording;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// Bytes of a row of a recording in full precision, at most.
const ROW_BYTES: usize = 1000;
/// Cells of a measured row besides commands and further columns: trial, time, position, orientation,
/// validity, load, gravity and pattern, and the tip's force.
const MEASURED_CELLS: usize = 18;
/// Bytes of a cell in full precision, at most.
const CELL_BYTES: usize = 25;
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

/// Checks that what a plant measures under `commands` can be written to `file`. Errors as
/// [`check_recording`].
pub(crate) fn check_measured(file: &Path, commands: &Recording) -> CommandResult {
    Recording::check_name(file).map_err(CommandError::bad_input)?;
    check_file(file, measured_bytes(commands))
}

/// Bytes of a recording of `commands` with the tip, at most.
fn measured_bytes(commands: &Recording) -> usize {
    let given = commands.tendons() + commands.drives.len() + commands.extra.len();
    let cells = (commands.len() + 1) * (given + MEASURED_CELLS);
    cells * CELL_BYTES
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
    let written = write_bytes(&mut file, bytes).and_then(|()| file.sync_all());
    // A process with the same id on another machine may have removed the file already.
    let removed = std::fs::remove_file(&probe)
        .or_else(|error| if probe.exists() { Err(error) } else { Ok(()) });
    written.and(removed)
}

/// Writes as many bytes and no more: a small file fits on a disk that is nearly full.
fn write_bytes(file: &mut std::fs::File, bytes: usize) -> io::Result<()> {
    let block = [0x5a; 1 << 16];
    (0..bytes)
        .step_by(block.len())
        .try_for_each(|from| file.write_all(&block[..block.len().min(bytes - from)]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use spinebench::data::Actuation;

    /// Room for 60 KB: enough for a short recording.
    #[test]
    fn a_short_recording_needs_little_room() {
        let mut commands = Recording::new(Actuation::Lengths, 4);
        for row in 0..60 {
            commands.commands.push(&[0.0; 4]);
            commands.trial.push(0);
            commands.time_s.push(0.2 * f64::from(row));
        }
        let bytes = measured_bytes(&commands);
        assert!((10_000..60_000).contains(&bytes), "{bytes}");
    }

    /// A probe takes no more room than what is to be written.
    #[test]
    fn a_probe_has_the_size_of_the_output() {
        let folder = tempfile::tempdir().unwrap();
        for bytes in [0, 1, 10_000, 1 << 16, (1 << 16) + 1] {
            let name = folder.path().join("probe");
            let mut file = std::fs::File::create(&name).unwrap();
            write_bytes(&mut file, bytes).unwrap();
            assert_eq!(std::fs::metadata(&name).unwrap().len(), bytes as u64);
        }
    }
}
