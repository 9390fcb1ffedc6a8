//! `spinebench gather`.

use crate::cli::program::outputs::{REPORT_BYTES, check_folder};
use crate::cli::program::shared::ResultsArg;
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::runner::{self, MergeError, Progress};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Merge repetitions of one experiment that were run on machines without a common store (`--set
/// first_seed=N`), and write tables, claims and figures of all of them. For a single folder,
/// rewrite its claims and figures from its tables.
#[derive(Args)]
pub(crate) struct GatherCommand {
    /// Folder of the experiment under `results/`, one for each machine.
    #[arg(required = true, value_name = "RESULTS/EXPERIMENT")]
    parts: Vec<PathBuf>,
    #[command(flatten)]
    results: ResultsArg,
}

impl GatherCommand {
    pub(crate) fn execute(self, progress: &Progress) -> CommandResult {
        let out = self.results.folder(progress);
        check_folder(&out, REPORT_BYTES)?;
        let (name, mut publication) = runner::merge(&self.parts).map_err(|error| match error {
            MergeError::Publish(_) => CommandError::failed(error),
            _ => CommandError::bad_input(error),
        })?;
        let claims = BTreeMap::from([(name, publication.claims)]);
        publication.files.extend(runner::all_claims(&out, &claims).map_err(CommandError::failed)?);
        publication.notices.iter().for_each(|notice| progress.notice(notice));
        if publication.failed > 0 {
            progress.notice(&format!("{} trials failed", publication.failed));
        }
        runner::write_files(&out, &publication.files).map_err(CommandError::failed)
    }
}
