//! `spinebench gather`.

use super::shared::writable;
use super::{CommandError, CommandResult};
use clap::Args;
use spinebench::runner::{self, MergeError};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Merge repetitions of one experiment that were run on machines without a common store (`--set first_seed=N`), and write
/// tables, claims and figures of all of them. For a single folder, write its claims and figures again from its tables.
#[derive(Args)]
pub(super) struct GatherCommand {
    /// Folder of the experiment under `results/`, one for each machine.
    #[arg(required = true, value_name = "RESULTS/EXPERIMENT")]
    parts: Vec<PathBuf>,
    /// Folder to write `results/` and `plots/` in.
    #[arg(long, value_name = "DIR", default_value = ".")]
    out: PathBuf,
}

impl GatherCommand {
    pub(super) fn execute(self) -> CommandResult {
        let (name, mut publication) = runner::merge(&self.parts).map_err(|error| match error {
            MergeError::Publish(_) => CommandError::failed(error),
            _ => CommandError::bad_input(error),
        })?;
        writable(&self.out)?;
        let claims = BTreeMap::from([(name, publication.claims)]);
        publication.files.extend(runner::all_claims(&self.out, &claims).map_err(CommandError::failed)?);
        publication.notices.iter().for_each(|notice| eprintln!("{notice}"));
        if publication.failed > 0 {
            eprintln!("{} trials failed", publication.failed);
        }
        runner::write_files(&self.out, &publication.files).map_err(CommandError::failed)
    }
}
