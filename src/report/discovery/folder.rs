//! The folder that `discover` writes: the report with its figures and tables, proposed commands,
//! the model, and last `findings.json`.

use super::{DiscoveryReport, artifacts};
use crate::data::{DataError, Recording, write_atomic_batch};
use crate::report::ReportError;
use std::path::Path;

/// The files of the folder by name: those of [`artifacts`], `commands` as CSV (name and content),
/// `model.yaml` and `findings.json`.
///
/// # Errors
/// As [`artifacts`].
pub fn folder_files(
    report: &DiscoveryReport,
    commands: &[(&str, &Recording)],
    model_yaml: Vec<u8>,
) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
    let mut files: Vec<(String, Vec<u8>)> =
        artifacts(report)?.into_iter().map(|file| (file.name, file.bytes)).collect();
    for (name, recording) in commands {
        files.push(((*name).to_owned(), recording.to_csv(Path::new(name))?));
    }
    files.push(("model.yaml".to_owned(), model_yaml));
    files.push((FINDINGS.to_owned(), report.findings.to_json(Path::new(FINDINGS))?));
    Ok(files)
}

const FINDINGS: &str = "findings.json";

/// Writes the files into `out`, all of them or none, and removes commands there that an earlier
/// discovery proposed.
///
/// # Errors
/// [`DataError::Write`] when the folder cannot be made or a file not written.
pub fn write_folder(out: &Path, files: &[(String, Vec<u8>)]) -> Result<(), DataError> {
    let outdated: Vec<String> = old_commands(out)
        .into_iter()
        .filter(|old| files.iter().all(|(name, _)| name != old))
        .collect();
    write_atomic_batch(files.iter().map(|(name, bytes)| (out.join(name), bytes.as_slice())))?;
    for file in outdated {
        let _ = std::fs::remove_file(out.join(file));
    }
    Ok(())
}

/// Command files that an earlier discovery in this folder proposed.
fn old_commands(out: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(out.join(FINDINGS)).unwrap_or_default();
    let earlier: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    let proposals = earlier["proposals"].as_array().into_iter().flatten();
    let files = proposals.filter_map(|proposal| proposal["file"].as_str());
    files.filter(|file| is_commands(file)).map(str::to_owned).collect()
}

/// Whether a file of this name holds proposed commands.
pub fn is_commands(name: &str) -> bool {
    name.starts_with("next_") && name.ends_with(".csv") && !name.contains(['/', '\\'])
}
