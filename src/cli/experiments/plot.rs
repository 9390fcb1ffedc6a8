//! `spinebench plot`.

use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::runner::{Files, Progress, redraw, redraw_claims, write_files};
use std::path::{Path, PathBuf};

/// Draw the figures of published results in `plots/` from the tables in `results/`, without running
/// anything; the files equal those of a run byte for byte. Figures whose rows are not published are
/// not changed.
#[derive(Args)]
pub(crate) struct PlotCommand {
    /// Folders of results, such as `results/fig6` [default: all in `results/`, and the claims].
    #[arg(value_name = "RESULTS_FOLDER")]
    folders: Vec<PathBuf>,
    /// Folder to write `plots/` in.
    #[arg(long, value_name = "DIR", default_value = ".")]
    out: PathBuf,
}

impl PlotCommand {
    pub(crate) fn execute(self, progress: &Progress) -> CommandResult {
        let all = self.folders.is_empty();
        let folders = if all { published(Path::new("results"))? } else { self.folders };
        let mut files = Files::new();
        for folder in &folders {
            let bad =
                |words: String| CommandError::BadInput(format!("{}: {words}", folder.display()));
            if !folder.is_dir() {
                return Err(bad("found no folder, expected one of results".to_owned()));
            }
            let (pictures, notices) = redraw(folder).map_err(bad)?;
            notices.iter().for_each(|notice| progress.notice(notice));
            files.extend(pictures);
        }
        if all {
            files.extend(redraw_claims(Path::new(".")).map_err(CommandError::BadInput)?);
        }
        write_files(&self.out, &files).map_err(CommandError::failed)?;
        progress.say(&format!("{} files in {}", files.len(), self.out.join("plots").display()));
        Ok(())
    }
}

/// The folders of `results`, in the order of their names.
fn published(results: &Path) -> Result<Vec<PathBuf>, CommandError> {
    let entries = std::fs::read_dir(results).map_err(|error| {
        CommandError::BadInput(format!(
            "{}: {error}, expected published results",
            results.display()
        ))
    })?;
    let mut folders: Vec<PathBuf> =
        entries.flatten().map(|entry| entry.path()).filter(|path| path.is_dir()).collect();
    folders.sort();
    Ok(folders)
}
